"""Figures of what ``octant paper`` has measured."""
