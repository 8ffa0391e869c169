"""The command line. Each command is a class whose fields are its arguments; only this folder prints."""
