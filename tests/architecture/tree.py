"""What the checks share: the files of the tree, and cycles in what they use."""

import os
import pathlib

SOURCES = (".h", ".hpp", ".cpp", ".cc")


def files(root, *endings, tops=("proto", "core", "server", "client", "tests")):
    """(path relative to the root, file) of each file with one of these endings."""
    for top in tops:
        for folder, _, names in os.walk(root / top):
            for name in sorted(names):
                if name.endswith(endings):
                    file = pathlib.Path(folder, name)
                    yield str(file.relative_to(root)), file


def cycles(edges):
    """The groups of nodes that reach each other (Tarjan's strongly connected components).

    `edges` is {node: nodes that it uses}; groups of one node are left out.
    """
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in sorted(edges.get(node, ())):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            group = stack[stack.index(node):]
            del stack[stack.index(node):]
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return found
