"""Comparisons at equal error against stochastic renderers."""

PEERS = []


def lines(bench, peers):
    return []
