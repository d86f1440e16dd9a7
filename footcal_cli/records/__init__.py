"""What footcal writes: versioned JSON that cannot be misread, and the strict reader.

Every record names its schema and version; an unknown key, a newer version or another schema is
refused in one line. ``footcal schema`` prints the JSON Schemas.
"""
