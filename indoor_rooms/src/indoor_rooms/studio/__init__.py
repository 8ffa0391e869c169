"""Pictures of single objects, as users give them."""
