"""`benchmark export`: an exported agent where little is installed."""
