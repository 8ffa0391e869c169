"""What tests share: small scenes, rooms, agents, robots and broken files."""
