"""``hopslam report``: the results of one or several runs, as a page and as figures; ``hopslam animate``."""
