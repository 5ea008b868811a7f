"""The paper's own tables and figures, measured again: Table 2, Figs. 3, 7, 8 and 10, and the time of Fig. 21."""
