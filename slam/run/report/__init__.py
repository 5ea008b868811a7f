"""``hopslam report``: what came out of one run or several, as a page and as figures; ``hopslam animate``."""
