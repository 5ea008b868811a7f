"""The paper's own tables and figures, measured again: Table 2, Figs. 7, 8 and 10."""
