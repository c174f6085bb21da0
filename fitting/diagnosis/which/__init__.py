"""Which effect explains the records: the search, one effect after another and two together."""
