"""Materials, textures, prints and colours."""
