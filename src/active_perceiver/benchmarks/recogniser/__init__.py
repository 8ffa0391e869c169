"""`benchmark recogniser`: what each ingredient of the recogniser's training is worth."""
