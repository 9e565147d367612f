"""Pushover analysis of historic masonry, stone by stone: micro limit analysis, macroblocks, FE contact."""
