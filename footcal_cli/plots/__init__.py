"""Record to Figure: functions that draw and return, never show, never save."""
