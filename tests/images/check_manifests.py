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
# Keys and types that this release of the client does not know: of Kubernetes 1.31 and 1.33.
NEWER_KEYS = {"V1JobSpec": {"backoffLimitPerIndex": "int", "maxFailedIndexes": "int", "podFailurePolicy": "V1PodFailurePolicy"}}
NEWER_TYPES = {
    "V1PodFailurePolicy": {"rules": "list[V1PodFailurePolicyRule]"},
    "V1PodFailurePolicyRule": {"action": "str", "onExitCodes": "V1PodFailurePolicyOnExitCodesRequirement",
                               "onPodConditions": "list[V1PodFailurePolicyOnPodConditionsPattern]"},
    "V1PodFailurePolicyOnExitCodesRequirement": {"containerName": "str", "operator": "str", "values": "list[int]"},
    "V1PodFailurePolicyOnPodConditionsPattern": {"status": "str", "type": "str"},
}
NEEDED = {"rules", "action", "operator", "values", "type"}  # keys of NEWER_TYPES
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
    elif type_name != "object" and not hasattr(models, type_name):
        yield from problems_of_newer(value, NEWER_TYPES[type_name], where)
    elif type_name != "object":
        yield from problems_of_object(value, getattr(models, type_name), where)


def problems_of_newer(value, type_of_key, where):
    if not isinstance(value, dict):
        yield f"{where}: wants an object"
        return
    for key, item in value.items():
        if key in type_of_key:
            yield from problems_of(item, type_of_key[key], f"{where}.{key}")
        else:
            yield f"{where}.{key}: unknown"
    for key in sorted(NEEDED & type_of_key.keys() - value.keys()):
        yield f"{where}: {key} is missing"


def problems_of_object(value, kind, where):
    if not isinstance(value, dict):
        # The client has a type for values that are a number or a text: ports, quantities.
        if kind.__name__ != "IntOrString" and kind.openapi_types:
            yield f"{where}: wants an object"
        return
    attribute_of = {key: attribute for attribute, key in kind.attribute_map.items()}
    newer = NEWER_KEYS.get(kind.__name__, {})
    for key, item in value.items():
        if key in attribute_of:
            yield from problems_of(item, kind.openapi_types[attribute_of[key]], f"{where}.{key}")
        elif key in newer:
            yield from problems_of(item, newer[key], f"{where}.{key}")
        else:
            yield f"{where}.{key}: unknown"
    try:
        kind(**{attribute_of[key]: item for key, item in value.items() if key in attribute_of})
    except ValueError as error:  # a missing key or a value that is not allowed
        yield f"{where}: {error}"


def problems_of_job(job, where):
    """Rules of the API for Jobs that continue after failures; types cannot express them."""
    per_index = "backoffLimitPerIndex" in job
    if per_index and job.get("completionMode") != "Indexed":
        yield f"{where}: backoffLimitPerIndex needs completionMode Indexed"
    rules = job.get("podFailurePolicy", {}).get("rules", [])
    if rules and job["template"]["spec"].get("restartPolicy") != "Never":
        yield f"{where}: podFailurePolicy needs restartPolicy Never"
    for number, rule in enumerate(rules):
        here = f"{where}.podFailurePolicy.rules[{number}]"
        codes = rule.get("onExitCodes", {}).get("values", [1])
        if rule["action"] not in {"Count", "FailIndex", "FailJob", "Ignore"}:
            yield f"{here}: unknown action {rule['action']}"
        if rule["action"] == "FailIndex" and not per_index:
            yield f"{here}: FailIndex needs backoffLimitPerIndex"
        if ("onExitCodes" in rule) == ("onPodConditions" in rule):
            yield f"{here}: wants either onExitCodes or onPodConditions"
        if codes != sorted(set(codes)) or not codes:
            yield f"{here}: exit codes want an order, and each once"


def problems_in(text):
    """Problems in all documents of a YAML file."""
    for document in yaml.safe_load_all(text):
        where = f"{document.get('kind')} {document.get('metadata', {}).get('name')}"
        kind = type_of(document)
        if kind is None:
            yield f"{where}: no such kind in {document.get('apiVersion')}"
        else:
            problems = list(problems_of_object(document, kind, where))
            yield from problems or (problems_of_job(document["spec"], where) if document["kind"] == "Job" else [])


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
