"""Training, evaluation and the demo as a whole: each a command, each with a result file."""
