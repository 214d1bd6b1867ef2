"""A wheelset at several lateral shifts (`femic shifts`): results of all contacts, charts and page."""
