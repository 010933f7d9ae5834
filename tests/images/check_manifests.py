#!/usr/bin/python3
"""Checks docker/kubernetes against the types of Kubernetes' API, as Debian's python3-kubernetes has them.

usage: check_manifests.py FOLDER

Prints a line for each unknown key, wrong type and missing key. Exits with 1 if there is one, or if there is
no manifest. kubectl would need a server to check manifests.
"""

import re
import sys
from datetime import datetime
from pathlib import Path

import yaml
from kubernetes.client import models

SCALARS = {"str": str, "int": int, "float": (int, float), "bool": bool, "datetime": (str, datetime)}
# Names that this release of the client does not know, with their older names.
OLDER = {"V2HorizontalPodAutoscaler": "V2beta2HorizontalPodAutoscaler"}
# Files for kubectl and for a chart, which are not objects of the API.
NOT_OF_THE_API = {"kustomization.yaml", "prometheus-adapter.yaml"}


def type_of(document):
    """The client's type for an object, by apiVersion and kind: apps/v1 Deployment is V1Deployment."""
    version = document.get("apiVersion", "").rpartition("/")[2]
    name = version[:1].upper() + version[1:] + document.get("kind", "")
    return getattr(models, name, None) or getattr(models, OLDER.get(name, ""), None)


def problems_of(value, type_name, where):
    """Yields the problems of a value, by the client's name of its type."""
    if match := re.fullmatch(r"list\[(.*)\]", type_name):
        if not isinstance(value, list):
            yield f"{where}: wants a list"
            return
        for number, item in enumerate(value):
            yield from problems_of(item, match[1], f"{where}[{number}]")
    elif match := re.fullmatch(r"dict\(str, (.*)\)", type_name):
        if not isinstance(value, dict):
            yield f"{where}: wants a map"
            return
        for key, item in value.items():
            yield from problems_of(item, match[1], f"{where}.{key}")
    elif type_name in SCALARS:
        if not isinstance(value, SCALARS[type_name]) or (type_name != "bool" and isinstance(value, bool)):
            yield f"{where}: {value!r} is no {type_name}"
    elif type_name != "object":
        yield from problems_of_object(value, getattr(models, type_name), where)


def problems_of_object(value, kind, where):
    if not isinstance(value, dict):
        # The client has a type for values that are a number or a text: ports, quantities.
        if kind.__name__ != "IntOrString" and kind.openapi_types:
            yield f"{where}: wants an object"
        return
    attribute_of = {key: attribute for attribute, key in kind.attribute_map.items()}
    for key, item in value.items():
        if key not in attribute_of:
            yield f"{where}.{key}: unknown"
        else:
            yield from problems_of(item, kind.openapi_types[attribute_of[key]], f"{where}.{key}")
    try:
        kind(**{attribute_of[key]: item for key, item in value.items() if key in attribute_of})
    except ValueError as error:  # a missing key or a value that is not allowed
        yield f"{where}: {error}"


def problems_in(text):
    """Problems in all documents of a YAML file."""
    for document in yaml.safe_load_all(text):
        where = f"{document.get('kind')} {document.get('metadata', {}).get('name')}"
        kind = type_of(document)
        if kind is None:
            yield f"{where}: no such kind in {document.get('apiVersion')}"
        else:
            yield from problems_of_object(document, kind, where)


def main():
    found = 0
    files = [file for file in sorted(Path(sys.argv[1]).glob("*.yaml")) if file.name not in NOT_OF_THE_API]
    if not files:
        sys.exit(f"no manifest in {sys.argv[1]}")
    for file in files:
        for problem in problems_in(file.read_text()):
            print(f"{file}: {problem}")
            found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
