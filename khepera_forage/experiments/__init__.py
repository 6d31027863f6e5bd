"""Arguments, processes, rows, tables, figures and pages of all benchmarks.

How to write a benchmark:

```python
@dataclass(frozen=True, slots=True)
class Forage:                                     # a table of rows is a frozen dataclass
    seed: int
    steps: int

class Start(NamedTuple):                          # a unit is work for any process, in any order
    seed: int

    @property
    def key(self) -> str: return str(self.seed)   # names the unit in the results' folder

    def run(self) -> list[Forage]: ...            # its rows; tables of several types may be mixed

if __name__ == "__main__":
    given = parse("forages", __doc__, Count("starts", 500, 5, "random starts", adds_units=True))
    seeds = np.random.SeedSequence(given.seed).generate_state(given.starts).tolist()
    rows = collect(given, [Start(seed) for seed in seeds], {Forage: "forages"}).of(Forage)
    table = Table("forages", "Steps of a forage", "Median and ...", columns, [quantiles(...)])
    finish(given, Page("Forages", ["What a reader learns.", table, Picture("forages", "steps", figure)]))
```

`parse` provides `--quick`, `--seed`, `--out`, `--jobs` and `--fresh`; `collect` runs the units in processes, writes
each unit's rows when the unit is done, and continues a run that was killed; `finish` writes `forages.md`, the tables
(`table_*.csv`) and the pictures to `--out`, and prints the tables. `measures` has means, differences and quantiles with
intervals, `figures` has panels and level bars.
"""
