"""Two runs side by side: compare.py OURS OTHER NAME=TOLERANCE…, NAME a metric or COLUMN@TIME of series.csv (its value at the
row nearest to that time). Tolerances are relative; exit 1 if one is exceeded."""
import csv, json, sys


def value(folder, name):
    if "@" not in name:
        metric = json.load(open(f"{folder}/summary.json"))["metrics"][name]
        return metric["value"] if isinstance(metric, dict) else metric
    column, time = name.split("@")
    with open(f"{folder}/series.csv") as file:
        row = min(csv.DictReader(file), key=lambda row: abs(float(row["t"]) - float(time)))
    return float(row[column])


ours, other, failed = sys.argv[1], sys.argv[2], False
for name, tolerance in (word.split("=") for word in sys.argv[3:]):
    a, b = value(ours, name), value(other, name)
    error = b / a - 1
    failed |= not abs(error) <= float(tolerance)
    print(f"  {name:32} ours {a:<12.6g} theirs {b:<12.6g} {error:+.1e}  (allowed {float(tolerance):.0e})")
sys.exit(failed)
