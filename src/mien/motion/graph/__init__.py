"""The Anime Graph (Cao et al. 2005): recorded motion kept phone by phone, and found again for new speech.

`graph` holds what was recorded, `query` says what is looked for, `costs` what a way through the graph costs; `search`
finds the cheapest.
"""
