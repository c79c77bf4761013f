"""How near synthesised motion comes to recorded motion: metrics with fixed definitions, protocols and baselines.

One module for each family of metrics, all of one shape (conventions, ``validate``, metrics), after mir_eval
(Raffel et al. 2014): `distance`, `trajectory`, `closure`, `published`, `jitter`, `sync`. Each metric is a pure
function of arrays. The definitions stand in ``docs/metrics.md``.
"""
