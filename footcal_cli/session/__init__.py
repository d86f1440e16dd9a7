"""One run of one command: what was asked, what was read, and the folder that it leaves."""
