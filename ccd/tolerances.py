"""Every tolerance of the collision detection, with its unit and what it buys."""

EXACT = 1e-5                # relative step of lambda at which Newton stops; lambda then errs by about its square, the gap by its 4th power
SHARP = 1e-8                # the same where lambda itself is wanted to the last digits: one more step, now and then
COARSE = 3e-2               # the same for a plane that only has to separate: every lambda gives a certificate, this one nearly the best
PENCIL_STEPS = 60           # cap of Newton with bisection; 2 to 5 are used, bisection alone would need 50
TOUCHING = 1e-14            # gap at which two bodies touch, in units of the sum of their support values along the normal
TOUCHING_STATE = 1e-12      # |f - 1| below which a static pair is called TOUCHING: what float64 can tell (paper errata, Theorem 1)
TOUCHING_POINT = 1e-6       # |f - 1| up to which a pair has a contact point by Theorem 2; it then errs by half of this, relatively
SHOOT_STEPS = 2000          # cap of the certified shoot; a regular contact takes about 10, grazing ones more; then UNRESOLVED
ROUNDING = 4e-15            # relative error of the terms of the characteristic polynomial over the aspect ratio of B: some 20 roundings
UNDERFLOW = 1e-280          # discriminant (of roots in units of the relative sizes) below which float64 loses digits; then f decides
CANCELLING = 4e-16          # what float64 loses in a difference of squares, relative to the squares
SPHERE_MARGIN = 1e-9        # relative widening of bounding spheres, so that the window they leave loses nothing to rounding
LAG = 1.0                   # twice the share of its gap that a plane may lose by not being the best one before time stops to make it better
ROOT = 2e-16                # width, in units of the interval searched, at which Bézier clipping has found a root
LOST = 1e-13                # width of a clipped piece, and its value over the largest one, where rounding has lost the root that it had
CLIPS_WELL = 0.8            # part of an interval left by clipping above which it is halved instead: several roots are near (Nishita et al.)
CLIPPING_STEPS = 400        # cap of Bézier clipping; a simple root takes 4 to 6
VANISHING = 1e-13           # part of a polynomial's largest control point below which a denominator counts as zero
CONCENTRIC = 1e-6           # f at u = 1/2 below which a deep overlap is not looked into further
ARRIVED = 1e-15             # f - 1 at which a recursive Bézier shoot has arrived: the last places of f
CONTACT_TIME_STEPS = 100    # cap of the false position for a contact instant; about 8 are used
NARROW = 1e-14              # width, in units of the time span, at which an undecided interval is left UNRESOLVED
SIDE = 1e-12                # first step, in units of the time span, beside an end where the bodies touch (the paper's epsilon, Remark 3)
LOOP_ROUNDS = 40            # cap of cutting down the sub-region of a loop test; it ends as soon as little comes off
STRIP = 1 / 16              # width in u of the narrowest strip in which a loop test is tried, before time is divided
CANDIDATES = 4000           # cap of the candidate intervals looked at; Example 1 takes 10, what is left then is UNRESOLVED
CONDITION = 300.0           # of a grid (its terms cancel to one part in so many) above which the span is halved: f then errs by some 1e-14
HALVINGS = 12               # cap of that
EXTREME = 1e250             # det X of one body times the other's denominators, or its inverse, from which F is not held
SMALLEST = 1e-12            # size of A in units of B below which F is not held: its best u is then too near 1 for float64 to tell from it
TANGENT = 1e-3              # width, in units of the time span, up to which a TOUCHING piece is one tangential contact
CONTACT_EXCESS = 1e-9       # |f - 1| up to which the end of an interval is a contact that has a point
SHORT_TURN = 5e-3           # squared radians that a free top swerves in half the time up to which its series are exact to the last bits
STEADY = 1e-34              # share of them, by which the momentum moves in the body, below which it turns steadily: 1e-17 of an angle
DOUBLINGS = 600             # cap of doubling a time; any flight that float64 can hold takes fewer
PERIOD = 1e-40              # squared radians, far below rounding, that keep what divides from 0 half a period from a pole
