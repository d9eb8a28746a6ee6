"""Soft shadows."""
