"""`benchmark scale`: what training costs as scenes get more and larger."""
