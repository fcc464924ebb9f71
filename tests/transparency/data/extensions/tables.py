"""Data frames of pandas (Cython) and Polars (Rust)."""

import pandas as pd
import polars as pl

GAIN = 0.5
LIMIT = 3
NAME = "front"

frame = pd.DataFrame({"a": [1, LIMIT, 5], "b": [GAIN, 1.5, 2.5], NAME: ["x", NAME, "z"]})
frame["c"] = frame["b"] * GAIN
frame.loc[LIMIT] = [4, GAIN, NAME, 1.0]
print(frame, frame.dtypes, frame[frame["a"] > LIMIT], frame.to_csv(), frame.head(2).to_json())
print(frame.groupby(NAME)["b"].sum(), frame.query("a > @LIMIT"), frame.iloc[LIMIT - 1].tolist())
print(pd.Timestamp("2024-01-01") + pd.Timedelta(seconds=GAIN), pd.cut(frame["b"], [0, GAIN, 3]))

other = pl.DataFrame({"a": [1, LIMIT, 5], "b": [GAIN, 1.5, 2.5], NAME: ["x", NAME, f"{NAME}/2"]})
print(other.filter(pl.col("a") > LIMIT - 1), other.with_columns((pl.col("b") * GAIN).alias("c")))
print(other.select(pl.col(NAME) == NAME), pl.Series(NAME, [GAIN, LIMIT]), other.row(LIMIT - 1))
