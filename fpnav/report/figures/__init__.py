"""Figures of a report: one module a kind, each a function from an entry to a drawing."""
