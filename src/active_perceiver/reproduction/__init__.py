"""The paper's experiments on this project's rooms: `active-perceiver reproduce ...`."""
