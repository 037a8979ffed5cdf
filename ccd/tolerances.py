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
