# SPDX-License-Identifier: Apache-2.0
"""CSV files as tables that survive an interruption: rows are appended one by one and keyed by their first columns."""

import csv
import os


class Table:
    """Rows of strings, appended to a file as they come. `key_columns` name what makes a row unique."""

    def __init__(self, path, columns, key_columns):
        self.path = path
        self.columns = columns
        self.key_columns = key_columns
        self.rows = read_rows(path) if os.path.exists(path) else []
        self._keys = {self.key(row) for row in self.rows}

    def key(self, row):
        return tuple(str(row[column]) for column in self.key_columns)

    def contains(self, row):
        return self.key(row) in self._keys

    def append(self, row):
        os.makedirs(os.path.dirname(self.path) or ".", exist_ok=True)
        is_new = not os.path.exists(self.path) or os.path.getsize(self.path) == 0
        with open(self.path, "a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns, extrasaction="ignore", restval="", lineterminator="\n")
            if is_new:
                writer.writeheader()
            writer.writerow(row)
        self.rows.append({column: str(row.get(column, "")) for column in self.columns})
        self._keys.add(self.key(row))

    def replace(self, row):
        """Like append, but a row of the same key is taken out first (the file is written anew)."""
        self.rows = [old for old in self.rows if self.key(old) != self.key(row)]
        self.rows.append({column: str(row.get(column, "")) for column in self.columns})
        self._keys.add(self.key(row))
        write_rows(self.path, self.columns, self.rows)


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_rows(path, columns, rows):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    partial = path + ".part"
    with open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    os.replace(partial, path)


def significant(value, digits=6):
    """A number as the shortest text with that many significant digits; other values unchanged."""
    return f"{value:.{digits}g}" if isinstance(value, float) else value
