"""Every tolerance and tuning number of the engine, with its unit and what it buys. The collision detection's are in ccd/tolerances.py."""

MARGIN = 0.42                # margin of a body's neighbourhood, in units of its equivalent radius (abc)^(1/3)
REBUILD_BEYOND = 0.7        # fraction of the margin that a body has really come when its list is rebuilt rather than extended
SURELY_NEAR = 0.7           # fraction of the sum of margins below which a neighbour stays without a better plane
SAFE = 1 - 1e-9             # factor on margins: covers the rounding of the displacement
REFINE_BELOW = 0.4          # a pair's plane is renewed when it holds for less than this, in units of the mean free time
IMMINENT = 0.2              # a contact nearer than this, in units of that time, is looked at again without a new plane on record
ALMOST = 1e-4               # a contact nearer than this, in units of that time, is looked for by the best plane, which may be its normal
FAR = 0.12                  # squared tilt of a plane from which Newton's method is not trusted to find the best one
ALIGNED = 1e-12             # squared tilt up to which a plane is the best one: it then errs by about as much, and the gap by its square
WELL_ALIGNED = 1e-4         # the square of that over the gap, in units of the supports, up to which it is good enough without a contact
CROSSED = 1e-12            # depth, in units of the supports, from which a plane that should be between two bodies cuts into them
NEWTON_STEPS = 6            # cap of steps of Newton's method for a plane; 1 or 2 are used
GRAZING = 1e-10             # gap, in units of the supports, below which a plane on record, in float32, would be worse than the best one
SHOTS = 8                   # cap of shots in a row at a contact that is near; two or three are used
LOOK_PAST = 2.0             # how far ahead a sharp bound looks, in units of the expected time to the contact
HORIZON_FREE_TIMES = 4.5    # how far ahead a bound of a pair looks, in mean free times
EPOCH_COLLISIONS = 4        # collisions per body between two upkeeps (and at least EPOCH_LEAST in all)
EPOCH_LEAST = 64
GROWTH_HORIZON = 1e-2       # relative growth for which one prediction is made, at most
FAINTEST = 1e-14            # approach of a dissipative collision, in units of the bodies' velocities, below which it is rounding
FAINT_COLLISIONS = 60       # of one pair in a row after which it has collapsed: of e = 0 one is as likely followed by another as not
FAINT_CHANGE = 20           # what one counts when the last was of another pair: three or four in turn are a collapse of three bodies
INSTANT_SHARE = 1e-15       # a time that is no progress, in thermal times, of a gas that can collapse
UNSTEADY = 1e-15            # share of its turning by which the axis of a body of revolution moves at least: it is known no better
DRIFTED = 1e-16             # share of the energy from which a common drift, the sum of rounding, is taken back
FOREVER = 1e299             # a time that never comes
STALL_EVENTS = 10_000       # events without progress of time (plus 100 per body) after which the engine gives up
FETCHED_AHEAD = 8192        # bodies from which memory is asked for before its event comes: fewer fit the caches
EVENTS_AT_ONCE = 1_000_000  # events between two looks of Python for an interrupt
LIST_ROOM = 16              # first capacity of a neighbour list
MORE_ROOM = 4               # by how much it grows when needed, at least
CELL_BODIES = 5.0           # bodies in a cell of a grid, on average
CELL_ROOM = 12              # first capacity of a cell
NARROWEST = 0.5             # width of a cell, at least, in units of the largest list radius of its level
FLOAT32_SLACK = 4e-7        # relative widening of a search whose positions are float32
OVERLAP = 1e-10             # relative depth from which two bodies handed over or read from a file count as overlapping
