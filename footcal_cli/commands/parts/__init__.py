"""What a command that outgrows its file keeps beside it; only commands import from here."""
