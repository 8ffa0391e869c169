"""Figures: boxes on views, floor plans with paths, videos, the report page, contact sheets."""
