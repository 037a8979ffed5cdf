"""Every tolerance of the collision detection, with its unit and what it buys."""

EXACT = 1e-5                # relative step of lambda at which Newton stops; lambda then errs by about its square, the gap by its 4th power
COARSE = 3e-2               # the same for a plane that only has to separate: every lambda gives a certificate, this one nearly the best
PENCIL_STEPS = 60           # cap of Newton with bisection; 2 to 5 are used, bisection alone would need 50
TOUCHING = 1e-14            # gap at which two bodies touch, in units of the sum of their support values along the normal
TOUCHING_STATE = 1e-12      # |f - 1| below which a static pair is called TOUCHING: what float64 can tell (paper errata, Theorem 1)
SHOOT_STEPS = 2000          # cap of the certified shoot; a regular contact takes about 10, grazing ones more; then UNRESOLVED
HORIZON_ROUNDS = 2          # looks for the longest reach of a turning plane; each round is on the safe side
CANCELLING = 4e-16            # what float64 loses in a difference of squares, relative to the squares
SPHERE_MARGIN = 1e-9        # relative widening of bounding spheres, so that the window they leave loses nothing to rounding
LAG = 0.4                   # share of the gap that a plane may lose by not being the best one before it is made better
