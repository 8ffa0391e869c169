"""Work spread over processes, and kept as it is done."""
