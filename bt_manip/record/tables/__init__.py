"""Control steps as tables: the trace of a run, and CSV and Parquet files of recordings."""
