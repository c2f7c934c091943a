"""check_conan_recipe.py CONANFILE: parses the recipe, and checks that its `_clone` is this clone."""

import ast
import os
import sys

path = os.path.abspath(sys.argv[1])
with open(path, encoding="utf-8") as file:
    tree = ast.parse(file.read())
(clone,) = [
    node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == "_clone"
]
up = [argument.value for argument in clone.body[0].value.args[1:]]
manifest = os.path.normpath(os.path.join(os.path.dirname(path), *up, "package.json"))
if not os.path.exists(manifest):
    sys.exit(f"{path}: _clone: expected a folder with package.json, found none: {manifest}")
