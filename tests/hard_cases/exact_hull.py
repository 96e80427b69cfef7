"""Signed distance of two convex hulls in exact rational arithmetic. Standard library only; shares nothing with the C++ code.

Every direction n bounds the signed distance from below: d >= (min_B n.b - max_A n.a) / |n|. The bound is attained for n out
of a finite set: cross products of edges of A, of edges of B, and of one of each (every facet of the Minkowski difference
has such a normal), and, for hulls that are apart, vertex to vertex and vertex to edge directions. So d is the largest bound.
Where the hulls are apart the nearest point found is proved to lie in the difference against all of its facets.
"""

import decimal
import itertools
import math
from fractions import Fraction

decimal.getcontext().prec = 120
decimal.getcontext().Emin = decimal.MIN_EMIN
decimal.getcontext().Emax = decimal.MAX_EMAX


def dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def sub(u, v):
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


def cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def primitive(n):
    """The shortest integer vector along n: equal directions become equal tuples."""
    g = math.gcd(math.gcd(n[0], n[1]), n[2])
    return (n[0] // g, n[1] // g, n[2] // g) if g else None


def as_integers(hulls):
    """Doubles as integers over one power of two."""
    scale = 1
    for hull in hulls:
        for p in hull:
            for c in p:
                scale = max(scale, Fraction(c).denominator)
    return [[tuple(int(Fraction(c) * scale) for c in p) for p in hull] for hull in hulls], scale


def facet_directions(a, b):
    edges = [[sub(q, p) for p, q in itertools.combinations(sorted(set(hull)), 2)] for hull in (a, b)]
    pairs = itertools.chain(itertools.combinations(edges[0], 2), itertools.combinations(edges[1], 2),
                            itertools.product(edges[0], edges[1]))
    found = set()
    for u, v in pairs:
        n = primitive(cross(u, v))
        if n:
            found.add(n)
            found.add((-n[0], -n[1], -n[2]))
    return found


def feature_directions(a, b):
    """From the nearest point of A to that of B: vertex to vertex, vertex to the line of an edge."""
    found = set()
    for p in a:
        for q in b:
            found.add(primitive(sub(q, p)))
    for points, lines, sign in ((a, b, 1), (b, a, -1)):
        for (p, q) in itertools.combinations(sorted(set(lines)), 2):
            e = sub(q, p)
            ee = dot(e, e)
            for v in set(points):
                w = sub(p, v)
                t = dot(w, e)
                found.add(primitive(tuple(sign * (ee * w[i] - t * e[i]) for i in range(3))))
    found.discard(None)
    return found


def bound(n, a, b):
    return min(dot(n, p) for p in b) - max(dot(n, p) for p in a)


def is_larger(s, nn, best):
    """s / sqrt(nn) > best s / sqrt(best nn)."""
    return best is None or s * abs(s) * best[1] > best[0] * abs(best[0]) * nn


def decimal_text(s, nn, scale):
    """s / (sqrt(nn) scale) to 40 significant digits."""
    if s == 0:
        return "0"
    value = decimal.Decimal(s) / decimal.Decimal(nn).sqrt() / decimal.Decimal(scale)
    return format(value, ".39e")


def unit(n):
    length = decimal.Decimal(dot(n, n)).sqrt()
    return [float(decimal.Decimal(c) / length) for c in n]


def prove_nearest(best, facets):
    """x = n s / |n|^2 is in B - A: no facet of the difference has it outside."""
    s, nn, n = best
    for m, least in facets.items():
        assert dot(m, n) * s >= least * nn, "the nearest point is not in the difference"


def signed_distance(world_a, world_b):
    """Returns (class, decimal text, normal or None)."""
    (a, b), scale = as_integers((world_a, world_b))
    facets = {n: bound(n, a, b) for n in facet_directions(a, b)}
    candidates = dict(facets)
    if max(facets.values()) > 0:
        for n in feature_directions(a, b):
            candidates.setdefault(n, bound(n, a, b))
    best = None
    for n, s in candidates.items():
        nn = dot(n, n)
        if is_larger(s, nn, best):
            best = (s, nn, n)
    s, nn, n = best
    if s > 0:
        prove_nearest(best, facets)
    ties = [m for m, t in candidates.items() if t * abs(t) * nn == s * abs(s) * dot(m, m)]
    name = "separated" if s > 0 else "touching" if s == 0 else "penetrating"
    return name, decimal_text(s, nn, scale), unit(n) if len(ties) == 1 else None
