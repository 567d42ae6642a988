"""Where the numbers of a mechanism file are."""


def counts(link):
    """Coordinates and rates of a link's joint."""
    kind, axes = link["joint"]["kind"], link["joint"]["axes"]
    return {"free": (7, 6), "ball": (4, 3), "fixed": (0, 0)}.get(kind, (len(axes), len(axes)))


def places(links):
    """Per link: its places among the file's coordinates, and among its rates."""
    result, at, rate = [], 0, 0
    for link in links:
        q, u = counts(link)
        result.append((list(range(at, at + q)), list(range(rate, rate + u))))
        at, rate = at + q, rate + u
    return result


def depth_first(links):
    """Links in the order in which both peers have their joints: Pinocchio's derivatives are wrong,
    without a word, in any other (its issue 1897)."""
    children = {}
    for index, link in enumerate(links):
        children.setdefault(link["parent"], []).append(index)
    order, waiting = [], children[None][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])[::-1]
    return order
