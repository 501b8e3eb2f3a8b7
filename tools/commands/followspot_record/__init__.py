"""Commands around recordings: record, replay, verify, export."""
