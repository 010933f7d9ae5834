"""Rows of benchmarks: one JSON object per line. Strings name a row, numbers are results; compare.py reads them."""
import json


def print_row(**row):
    """Prints a row; floating-point figures get five significant digits."""
    print(json.dumps({key: float(f"{value:.5g}") if isinstance(value, float) else value for key, value in row.items()},
                     ensure_ascii=False), flush=True)
