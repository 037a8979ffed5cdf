# ruff: noqa
#!/usr/bin/env python3
"""Reference results for hard-ellipsoid event-driven MD. numpy + scipy only.

Run `python reference.py` for the self-check (about 1-2 min), or import.
Conventions: semi-axes a,b,c ; V = 4/3 pi abc ; phi = n V ; n number density ;
kT and m explicit ; uniform mass inertia I = m/5 diag(b2+c2, a2+c2, a2+b2).
Z = P/(n kT).  Gamma = collision rate PER PARTICLE (total rate = N Gamma / 2).
"""
import math
import numpy as np
from scipy.special import elliprg, ellipj, ellipk
from scipy.optimize import brentq

pi = math.pi

# --------------------------------------------------------------------------- geometry
def geometry(a, b, c):
    """volume V, surface S, mean radius of curvature R = (1/4pi) int H dS = mean support function.
    Exact through Carlson R_G (DLMF 19.16.3, 19.33.1)."""
    V = 4 * pi / 3 * a * b * c
    S = 4 * pi * elliprg(a*a*b*b, b*b*c*c, c*c*a*a)
    R = elliprg(a*a, b*b, c*c)
    return V, S, R

def spheroid_S_R(a, c):
    """closed forms, spheroid semi-axes (a,a,c): check of geometry()."""
    if abs(c/a - 1) < 1e-12:
        return 4*pi*a*a, a
    if c > a:
        e = math.sqrt(1 - a*a/(c*c))
        S = 2*pi*a*a*(1 + c/(a*e)*math.asin(e))
        R = 0.5*c + a*a/(2*c*e)*math.atanh(e)
    else:
        e = math.sqrt(1 - c*c/(a*a))
        S = 2*pi*a*a*(1 + (1-e*e)/e*math.atanh(e))
        R = 0.5*c + a/(2*e)*math.asin(e)
    return S, R

def alpha_nonsphericity(a, b, c):
    V, S, R = geometry(a, b, c)
    return R*S/(3*V)

def B2star(a, b, c):
    """B2/V = 1 + R S / V (exact, Isihara-Hadwiger; any convex body)."""
    V, S, R = geometry(a, b, c)
    return 1 + R*S/V

# --------------------------------------------------------------------------- hard spheres
HS_VIRIAL = [1., 4., 10., 18.364768, 28.224512, 39.815148, 53.344420, 68.537549, 85.812838,
             105.775104, 127.93]   # coefficients of eta^k in Z, k=0..10 (last ones to MC accuracy)

def Z_CS(eta):
    return (1 + eta + eta**2 - eta**3)/(1 - eta)**3

def Z_KLM(eta):
    """Kolafa-Labik-Malijevsky 2004 fluid EOS, good to ~1e-4 up to freezing (coefficients from memory,
    verified against virial coefficients in selfcheck)."""
    x = eta/(1 - eta)
    c = [1, 4, 6, 2.3647684, -0.8698551, 1.1062803, -1.095049, 0.637614, -0.2279397, 0.1098948, -0.00906797]
    return sum(ck*x**k for k, ck in enumerate(c))

def g_contact(eta, Z=Z_KLM):
    return (Z(eta) - 1)/(4*eta)

def enskog_rate(n, sigma=1., kT=1., m=1., Z=Z_KLM):
    """exact equilibrium collision rate per particle of hard spheres, given exact g(sigma)."""
    eta = pi/6*n*sigma**3
    return 4*n*sigma**2*g_contact(eta, Z)*math.sqrt(pi*kT/m)

def D_enskog(n, sigma=1., kT=1., m=1., Z=Z_KLM):
    """first Sonine approximation; the full Enskog value is 1.01896 times this."""
    return 3/(8*n*sigma**2*g_contact(pi/6*n*sigma**3, Z))*math.sqrt(kT/(pi*m))

def D_speedy(n, sigma=1., kT=1., m=1.):
    """Speedy 1987 (abstract seen; polynomial from memory)."""
    r = n*sigma**3
    return 3/8*sigma*math.sqrt(kT/(pi*m))/r*(1 - r/1.09)*(1 + r*r*(0.4 - 0.83*r*r))

def fcc_hall(eta):
    """Hall 1972 fcc hard-sphere crystal; beta = 4(1-eta/eta_cp). (memory, checked: Z(0.545)=11.1 )"""
    ecp = pi*math.sqrt(2)/6
    b = 4*(1 - eta/ecp)
    return (12 - 3*b)/b + 2.557696 + 0.1253077*b + 0.1762393*b**2 - 1.053308*b**3 \
        + 2.818621*b**4 - 2.921934*b**5 + 1.118413*b**6

# --------------------------------------------------------------------------- hard convex bodies
def Z_parsons_lee(phi, axes):
    return 1 + (B2star(*axes)/4)*(Z_CS(phi) - 1)

def Z_vega(phi, axes):
    """Vega 1997 (McBride & Lomba 2007 eq.): B2 exact, B3..B5 fits, CS remainder scaled by B2*/4."""
    V, S, R = geometry(*axes)
    t = 4*pi*R*R/S - 1
    al = R*S/(3*V) - 1
    B2 = 1 + R*S/V
    B3 = 10 + 13.094756*al - 2.073909*t + 4.096689*al**2 + 2.325342*t**2 - 5.791266*al*t
    B4 = (18.3648 + 27.714434*al - 10.2046*t + 11.142963*al**2 + 8.634491*t**2 - 28.279451*al*t
          - 17.190946*al**2*t + 24.188979*al*t**2 + 0.74674*al**3 - 9.455150*t**3)
    B5 = (28.2245 + 21.288105*al + 4.525788*t + 36.032793*al**2 + 59.0098*t**2 - 118.407497*al*t
          + 24.164622*al**2*t + 139.766174*al*t**2 - 50.490244*al**3 - 120.995139*t**3 + 12.624655*al**3*t)
    y = phi
    return (1 + B2*y + B3*y**2 + B4*y**3 + B5*y**4
            + B2/4*(Z_CS(y) - 1 - 4*y - 10*y**2 - 18.3648*y**3 - 28.2245*y**4))

def vega_virials(axes):
    V, S, R = geometry(*axes); t = 4*pi*R*R/S - 1; al = R*S/(3*V) - 1
    B3 = 10 + 13.094756*al - 2.073909*t + 4.096689*al**2 + 2.325342*t**2 - 5.791266*al*t
    return 1 + R*S/V, B3

def Z_nezbeda(phi, axes):
    """Nezbeda 1976 convex-body EOS."""
    a = alpha_nonsphericity(*axes); y = phi
    return (1 + (3*a - 2)*y + (a*a + a - 1)*y*y - a*(5*a - 4)*y**3)/(1 - y)**3

def Z_boublik(phi, axes):
    """Boublik 1981 (improved SPT). (memory; reduces to CS for a=1, exact B2; within 2% of own MC)"""
    a = alpha_nonsphericity(*axes); y = phi
    return (1 + (3*a - 2)*y + (3*a*a - 3*a + 1)*y*y - a*(6*a - 5)*y**3)/(1 - y)**3

def Z_song_mason(phi, axes):
    """Song & Mason 1990 type: Z = 1 + B2 n G, G=(1-g1 y+g2 y^2)/(1-y)^3 with
    g1 = 3-(1+6a+3a^2)/(1+3a), g2 = 3-(2+2.64a+7a^2)/(1+3a). (memory; a=1 -> near CS)"""
    a = alpha_nonsphericity(*axes); y = phi
    g1 = 3 - (1 + 6*a + 3*a*a)/(1 + 3*a)
    g2 = 3 - (2 + 2.64*a + 7*a*a)/(1 + 3*a)
    return 1 + (1 + 3*a)*y*(1 - g1*y + g2*y*y)/(1 - y)**3

# --------------------------------------------------------------------------- overlap (Perram-Wertheim)
def quat_to_R(q):
    w, x, y, z = q/np.linalg.norm(q)
    return np.array([[1-2*(y*y+z*z), 2*(x*y-w*z), 2*(x*z+w*y)],
                     [2*(x*y+w*z), 1-2*(x*x+z*z), 2*(y*z-w*x)],
                     [2*(x*z-w*y), 2*(y*z+w*x), 1-2*(x*x+y*y)]])

def shape_matrix(axes, R):
    """A with surface x^T A^-1 x = 1, columns of R = body axes in the lab frame."""
    return (R*np.asarray(axes, float)**2) @ R.T

def pw(A, B, r):
    """F = max_l l(1-l) r^T[(1-l)A+lB]^-1 r. mu = sqrt(F) = scale at which the bodies touch.
    F>1 disjoint, F<1 overlap. returns F, lambda, unit normal (from A to B), contact point rel. to A centre
    of the mu-scaled bodies."""
    def dlog(l):
        G = (1-l)*A + l*B
        u = np.linalg.solve(G, r)
        return 1/l - 1/(1-l) - (u @ (B - A) @ u)/(r @ u)
    l = brentq(dlog, 1e-13, 1-1e-13, xtol=1e-15, rtol=8.9e-16)
    G = (1-l)*A + l*B
    u = np.linalg.solve(G, r)
    F = l*(1-l)*(r @ u)
    n = u/np.linalg.norm(u)
    xc = (1-l)*(A @ u)
    return F, l, n, xc

def pw_batch(A, B, r, nit=60):
    """vectorised PW by bisection on lambda. A,B (K,3,3), r (K,3) -> F (K,)"""
    lo = np.zeros(len(r)); hi = np.ones(len(r))
    D = B - A
    for _ in range(nit):
        l = 0.5*(lo+hi)
        G = A + l[:, None, None]*D
        u = np.linalg.solve(G, r[..., None])[..., 0]
        ru = np.einsum('ki,ki->k', r, u)
        d = 1/l - 1/(1-l) - np.einsum('ki,kij,kj->k', u, D, u)/ru
        up = d > 0
        lo = np.where(up, l, lo); hi = np.where(up, hi, l)
    l = 0.5*(lo+hi); G = A + l[:, None, None]*D
    u = np.linalg.solve(G, r[..., None])[..., 0]
    return l*(1-l)*np.einsum('ki,ki->k', r, u)

def random_rotations(rng, K):
    q = rng.normal(size=(K, 4)); q /= np.linalg.norm(q, axis=1)[:, None]
    w, x, y, z = q.T
    return np.stack([np.stack([1-2*(y*y+z*z), 2*(x*y-w*z), 2*(x*z+w*y)], -1),
                     np.stack([2*(x*y+w*z), 1-2*(x*x+z*z), 2*(y*z-w*x)], -1),
                     np.stack([2*(x*z-w*y), 2*(y*z+w*x), 1-2*(x*x+y*y)], -1)], 1)

def B2star_mc(axes, K=200000, seed=0):
    """Monte Carlo B2/V by Perram-Wertheim overlap fraction in the bounding sphere. returns mean, stderr."""
    rng = np.random.default_rng(seed)
    ax = np.asarray(axes, float); rc = 2*ax.max()
    R1 = random_rotations(rng, K); R2 = random_rotations(rng, K)
    A = np.einsum('kij,j,klj->kil', R1, ax**2, R1); B = np.einsum('kij,j,klj->kil', R2, ax**2, R2)
    u = rng.normal(size=(K, 3)); u /= np.linalg.norm(u, axis=1)[:, None]
    # importance sampling: for direction u, excluded volume = (4pi/3) rho^3, rho = 1/sqrt(F(u))
    F = pw_batch(A, B, u)
    rho3 = F**-1.5
    x = 0.5*(4*pi/3)*rho3/(4*pi/3*ax.prod())
    return x.mean(), x.std()/math.sqrt(K)

# --------------------------------------------------------------------------- exact dilute kinetic theory
def _face(axes, n, m=1.):
    """support h, det & trace of curvature-radius matrix, w = (r x n)^T I^-1 (r x n) for body-frame normal n (K,3)"""
    d = np.asarray(axes, float)**2
    An = n*d
    h = np.sqrt((n*An).sum(-1))
    det = d.prod()/h**4
    tr = d.sum()/h - (An*An).sum(-1)/h**3
    x = An/h[..., None]
    t = np.cross(x, n)
    I = m/5*np.array([d[1]+d[2], d[0]+d[2], d[0]+d[1]])
    return h, det, tr, t*t/I

def _sphere_quad(nth=24, nph=24):
    """Gauss-Legendre x uniform phi over one octant-symmetric sphere, weights sum to 1"""
    x, w = np.polynomial.legendre.leggauss(nth)
    ph = (np.arange(nph)+0.5)*2*pi/nph
    ct = x[:, None]*np.ones(nph); st = np.sqrt(1-ct**2)
    n = np.stack([st*np.cos(ph), st*np.sin(ph), ct], -1).reshape(-1, 3)
    W = (w[:, None]/2*np.ones(nph)/nph).reshape(-1)
    return n, W

def dilute(axes, m=1., kT=1., Ttr=None, Trot=None, nth=48, nph=48):
    """Exact low-density (n->0) equilibrium integrals for identical smooth ellipsoids, uniform orientations,
    Maxwellian velocities with Ttr, Trot (=kT by default). Everything per unit density n.
    returns dict: B2 (=check), gamma = Gamma/n, nu_v = VACF initial decay rate/n,
    nu_w = same for angular velocity (rotational kinetic-energy-weighted),
    dEtr, dErot = rates of change of mean translational / rotational energy per particle, /n, for e=1
    (zero at equilibrium) as functions needed by cooling(); diss = dissipation coefficient."""
    Ttr = kT if Ttr is None else Ttr
    Trot = kT if Trot is None else Trot
    n, W = _sphere_quad(nth, nph)
    h, det, tr, w3 = _face(axes, n, m)
    w = w3.sum(-1)
    J = det[:, None] + det[None, :] + 0.5*tr[:, None]*tr[None, :]
    WW = W[:, None]*W[None, :]
    minv = 2/m + w[:, None] + w[None, :]
    s = Ttr*2/m + Trot*(w[:, None] + w[None, :])        # variance of relative normal velocity
    f4 = 4*pi*WW*J
    B2 = 0.5/3*(f4*(h[:, None] + h[None, :])).sum()
    gamma = (f4*np.sqrt(s/(2*pi))).sum()
    # second moment of normal velocity over collisions: int v^3 p(v) = 2 s^1.5/sqrt(2pi)
    v3 = 2*s**1.5/math.sqrt(2*pi)
    # friction on particle 1: d<v.v0>/dt = -(m/3kT) n <int (2/(m minv)) v_n . v_n * kT/(m s) ...>
    # E[v1.n | v_n] = v_n (Ttr/m)/s
    nu_v = (f4*(2/(m*minv))*(Ttr/m)/s*v3).sum()/(3*Ttr/m)
    nu_w_E = (f4*(2/minv)*w[:, None]*Trot/s*v3).sum()/Trot   # d<w.I.w0>/dt / kT ; divide by number of active dof
    ndof_rot = 0 if np.allclose(axes, axes[0]) else (2 if (np.isclose(axes[0], axes[1]) or np.isclose(axes[1], axes[2]) or np.isclose(axes[0], axes[2])) else 3)
    out = dict(B2=B2, gamma=gamma, nu_v=nu_v, nu_w=(nu_w_E/ndof_rot if ndof_rot else 0.), ndof_rot=ndof_rot,
               Sexc=f4.sum())
    # energy exchange with restitution e: impulse j=(1+e) v_n/minv, v_n approach speed (>0)
    # particle-1 translational energy change: -j*E[v1.n_rel] + j^2/(2m); sum over both = 2x
    def rates(e):
        Em = f4
        jv = (1+e)/minv
        # mean of approach component carried by translation: E[(v1-v2).n | v_n] = v_n*(2Ttr/m)/s
        dtr = (Em*(-jv*(2*Ttr/m)/s + 0.5*jv**2*(2/m))*v3).sum()
        W2 = w[:, None]+w[None, :]
        drot = (Em*(-jv*(Trot*W2)/s + 0.5*jv**2*W2)*v3).sum()
        return 0.5*dtr, 0.5*drot      # per particle (half of pair energy, each pair counted once per particle -> n*(1/2))
    out['rates'] = rates
    return out

def dilute_rates_per_particle(axes, e, Ttr, Trot, **k):
    """dEtr/dt, dErot/dt per particle per density: collisions per particle per time = n*gamma; each collision is
    shared by two particles -> energy change per particle = n/2 * pair change."""
    return dilute(axes, Ttr=Ttr, Trot=Trot, **k)['rates'](e)

def cooling_ratio(axes, e, **k):
    """Two-temperature Maxwellian (dilute, isotropic) prediction of theta=Trot/Ttr in the homogeneous cooling state
    and the cooling-rate constant. Condition: (dTtr/dt)/Ttr = (dTrot/dt)/Trot."""
    f = dilute(axes, **k)['ndof_rot']
    def g(lth):
        th = math.exp(lth)
        dtr, dro = dilute_rates_per_particle(axes, e, 1., th, **k)
        return (2/3*dtr) - (2/f*dro)/th
    lth = brentq(g, -3, 14)
    th = math.exp(lth)
    dtr, dro = dilute_rates_per_particle(axes, e, 1., th, **k)
    return th, -(2/3*dtr)          # dTtr/dt = -zeta n Ttr^{3/2} (m=1)

def haff_tau(Gamma0, e, ndof):
    """Haff time for T(t)=T0/(1+t/tau)^2 with equipartition: dT/dt = -(1-e^2) Gamma T/ndof ; Gamma ~ sqrt(T).
    ndof = 3 smooth spheres (exact Enskog/Maxwellian), 5 spheroids, 6 triaxial (near-elastic limit)."""
    return 2*ndof/((1 - e*e)*Gamma0)

# --------------------------------------------------------------------------- collision rule
def collide(m1, I1, R1, v1, w1, r1, m2, I2, R2, v2, w2, r2, n, e=1.):
    """Smooth hard-body collision. n unit normal pointing from 1 to 2 at contact; r1,r2 contact point relative to
    centres; w lab-frame angular velocities; I* body-frame principal moments (3,), R* body axes in columns.
    returns v1,w1,v2,w2 after, impulse P (applied to 2 along +n, to 1 along -n)."""
    I1inv = (R1/np.asarray(I1)) @ R1.T; I2inv = (R2/np.asarray(I2)) @ R2.T
    a1 = np.cross(r1, n); a2 = np.cross(r2, n)
    vn = (v1 + np.cross(w1, r1) - v2 - np.cross(w2, r2)) @ n      # >0 approaching
    k = 1/m1 + 1/m2 + a1 @ I1inv @ a1 + a2 @ I2inv @ a2
    P = (1 + e)*vn/k
    return v1 - P*n/m1, w1 - P*I1inv @ a1, v2 + P*n/m2, w2 + P*I2inv @ a2, P

# --------------------------------------------------------------------------- free rotation
def free_spheroid(Iperp, Ipar, u0, w0, t):
    """symmetric top. u0 unit symmetry axis, w0 lab angular velocity. exact: u precesses about L at rate |L|/Iperp,
    body spins about u at w.u (L/Iperp = w + (Ipar/Iperp-1)(w.u)u).  returns u(t), w(t)."""
    w3 = w0 @ u0
    L = Iperp*w0 + (Ipar - Iperp)*w3*u0
    Om = np.linalg.norm(L)/Iperp
    if Om == 0:
        return u0.copy(), w0.copy()
    k = L/np.linalg.norm(L)
    c, s = math.cos(Om*t), math.sin(Om*t)
    rot = lambda v: v*c + np.cross(k, v)*s + k*(k @ v)*(1 - c)
    return rot(u0), rot(w0)

def free_triaxial_omega(I, w0, t):
    """body-frame angular velocity of a free triaxial top, I ascending or any order; Jacobi elliptic functions.
    General initial condition (no axis-aligned start needed). Returns w(t) (3,)."""
    I = np.asarray(I, float); w0 = np.asarray(w0, float)
    order = np.argsort(I)            # I1<=I2<=I3
    perm = np.eye(3)[order]; sgn = np.linalg.det(perm)
    i1, i2, i3 = I[order]; w = w0[order].copy()
    # an odd permutation mirrors the frame: map w -> w*sgn (pseudo-vector) so Euler equations keep their form
    w = w*sgn
    T2 = i1*w[0]**2 + i2*w[1]**2 + i3*w[2]**2; L2 = (i1*w[0])**2 + (i2*w[1])**2 + (i3*w[2])**2
    # a1 (largest-L side) conventions of Landau & Lifshitz sec. 37
    flip = L2 < T2*i2
    if flip:                         # exchange roles 1<->3
        i1, i3 = i3, i1; w = -w[[2, 1, 0]]
    A1 = math.sqrt(max((T2*i3 - L2)/(i1*(i3 - i1)), 0.)); A2 = math.sqrt(max((T2*i3 - L2)/(i2*(i3 - i2)), 0.))
    A3 = math.sqrt(max((L2 - T2*i1)/(i3*(i3 - i1)), 0.))
    p = math.sqrt((i3 - i2)*(L2 - T2*i1)/(i1*i2*i3)); mm = (i2 - i1)*(T2*i3 - L2)/((i3 - i2)*(L2 - T2*i1))
    s3 = 1. if w[2] >= 0 else -1.
    # w1 = A1 cn, w2 = s A2 sn, w3 = s3 A3 dn ; from Euler: i1 w1' = (i2-i3) w2 w3
    s2 = s3 if i3 > i2 else -s3
    ph0 = math.atan2(s2*w[1]/A2, w[0]/A1) if A1 > 0 else 0.
    from scipy.special import ellipkinc
    u0 = ellipkinc(ph0, mm)
    sn, cn, dn, _ = ellipj(u0 + p*t, mm)
    out = np.array([A1*cn, s2*A2*sn, s3*A3*dn])
    if flip:
        out = -out[[2, 1, 0]]
    out = out*sgn
    res = np.empty(3); res[order] = out
    return res

def free_rotor_C(axes, l, t, m=1., kT=1., K=64):
    """<P_l(u(0).u(t))> of the symmetry axis (third axis, axes=(a,a,c)) at zero density: exact average over Maxwell L.
    u.u0 = cos^2 th + sin^2 th cos(Om t), cos th = L3/L, Om = L/Iperp."""
    a, _, c = axes
    Ip = m/5*(a*a + c*c); I3 = 2*m/5*a*a
    x, wx = np.polynomial.hermite_e.hermegauss(120)     # L3 = sqrt(I3 kT) x
    y, wy = np.polynomial.laguerre.laggauss(100)        # Lperp^2/(2 Ip kT) = y
    L3 = math.sqrt(I3*kT)*x[:, None]; Lp2 = 2*Ip*kT*y[None, :]
    L2 = L3**2 + Lp2
    ct2 = L3**2/L2; Om = np.sqrt(L2)/Ip
    W = (wx/wx.sum())[:, None]*wy[None, :]
    cc = ct2 + (1 - ct2)*np.cos(Om*t)
    P = cc if l == 1 else 1.5*cc*cc - 0.5
    return (W*P).sum()

# --------------------------------------------------------------------------- crystals
def fcc_stretched(axes):
    """affine image of fcc: lattice vectors (columns) and touching density pi/sqrt18, 12 contacts."""
    D = np.diag(axes)*math.sqrt(2)
    Lv = D @ np.array([[1, 1, 0], [1, 0, 1], [0, 1, 1.]])
    return Lv

def sm2_crystal(ratio=math.sqrt(3.), c=1., s=1.):
    """Donev-type SM2 two-particle crystal, rebuilt here from symmetry.
    layer A: in-plane semi-axes (a along x, b along y), centred square net of side L=4ab/sqrt(a^2+b^2);
    layer B: the same rotated by 90 deg, displaced by (L/2,0,h). Third axis c along z. s stretches along (1,1,0)
    (maps A,B to congruent ellipsoids). ratio=a/b<=sqrt 3. Returns cell (columns; A at 0, B at tau), shapes, tau, h.
    cell is primitive: a1=(L/2,L/2,0), a2=(L/2,-L/2,0), a3=(0,0,2h)."""
    a, b = ratio, 1.
    L = 4*a*b/math.sqrt(a*a + b*b)
    A = np.diag([a*a, b*b, c*c]); B = np.diag([b*b, a*a, c*c])
    f = lambda h: pw(A, B, np.array([L/2, 0, h]))[0] - 1
    h = brentq(f, 1e-6, 4*c, xtol=1e-15)
    cell = np.array([[L/2, L/2, 0], [L/2, -L/2, 0], [0, 0, 2*h]]).T
    tau = np.array([L/2, 0, h])
    if s != 1.:
        e = np.array([1, 1, 0])/math.sqrt(2)
        M = np.eye(3) + (s - 1)*np.outer(e, e)
        cell = M @ cell; tau = M @ tau; A = M @ A @ M.T; B = M @ B @ M.T
    return cell, A, B, tau, h

def crystal_check(cell, shapes, pos, rng=2):
    """min PW mu^2 over all periodic pairs, contact counts per particle (tol 1e-9), density"""
    k = len(shapes); mn = 9e9; cnt = np.zeros(k, int)
    for i in range(k):
        for j in range(k):
            for o in np.ndindex(*(2*rng+1,)*3):
                sft = np.array(o) - rng
                d = pos[j] - pos[i] + cell @ sft
                if i == j and not sft.any():
                    continue
                F = pw(shapes[i], shapes[j], d)[0]
                mn = min(mn, F)
                if abs(F - 1) < 1e-8:
                    cnt[i] += 1
    vol = sum(4*pi/3*math.sqrt(np.linalg.det(s)) for s in shapes)
    return mn, cnt, vol/abs(np.linalg.det(cell))

# --------------------------------------------------------------------------- statistics of a correct NVE run
def active_dof(N, axes, com_fixed=True):
    """degrees of freedom that exchange energy. Smooth spheroids: spin about the symmetry axis is an exact
    constant of each particle and must be left out; smooth spheres: no rotation at all."""
    ax = sorted(axes)
    fr = 0 if abs(ax[0]-ax[2]) < 1e-14 else (2 if (abs(ax[0]-ax[1]) < 1e-14 or abs(ax[1]-ax[2]) < 1e-14) else 3)
    return 3*N - (3 if com_fixed else 0), fr*N

def rot_fraction_mean_std(N, axes):
    """exact microcanonical law: E_rot/E_active ~ Beta(f_r/2, f_t/2). mean and std of an instantaneous sample."""
    ft, fr = active_dof(N, axes)
    a, b = fr/2, ft/2
    return a/(a+b), math.sqrt(a*b/((a+b)**2*(a+b+1)))

def kurtosis_micro(N, axes):
    """exact <v^4>/<v^2>^2 of a momentum component weighted to unit mass in NVE (Gaussian limit 3), per D=f_t+f_r."""
    D = sum(active_dof(N, axes))
    return 3*D/(D+2)

# --------------------------------------------------------------------------- Lubachevsky-Stillinger growth
def collide_growing(m1, I1, R1, v1, w1, r1, m2, I2, R2, v2, w2, r2, n, sdot_over_s, e=1.):
    """as collide(), both bodies growing homothetically at rate sdot/s. Surface normal speed of each = (sdot/s) h_i and
    h1+h2 = (r1 - r2).n , so the approach speed gains g=(sdot/s)(r1-r2).n. For e=1 the kinetic energy rises by g*P."""
    I1inv = (R1/np.asarray(I1)) @ R1.T; I2inv = (R2/np.asarray(I2)) @ R2.T
    a1 = np.cross(r1, n); a2 = np.cross(r2, n)
    g = sdot_over_s*((r1 - r2) @ n)
    vn = (v1 + np.cross(w1, r1) - v2 - np.cross(w2, r2)) @ n + g
    k = 1/m1 + 1/m2 + a1 @ I1inv @ a1 + a2 @ I2inv @ a2
    P = (1 + e)*vn/k
    return v1 - P*n/m1, w1 - P*I1inv @ a1, v2 + P*n/m2, w2 + P*I2inv @ a2, P, g

def jammed_Z(phi, phiJ, ndof_per_particle, contacts=None):
    """free-volume law near jamming Z = f/(1-phi/phiJ): f = d_f if isostatic (3 spheres); heuristic (derived, not in
    the literature I could read) for hypostatic packings f = (d_f + contacts/2)/2 (second-order modes open as sqrt)."""
    f = ndof_per_particle if contacts is None else 0.5*(ndof_per_particle + contacts/2)
    return f/(1 - phi/phiJ)

# --------------------------------------------------------------------------- self check
def selfcheck(fast=False):
    ok = []
    def chk(name, got, want, tol):
        good = abs(got - want) <= tol
        ok.append(good)
        print(f"{'ok ' if good else 'BAD'} {name}: {got:.8g} vs {want:.8g} (tol {tol:g})")
    for ax in [(1, 1, 3.), (1, 1, 1/3), (1, 1, 1.0000001)]:
        V, S, R = geometry(*ax); S2, R2 = spheroid_S_R(ax[0], ax[2])
        chk(f"S{ax}", S, S2, 1e-9*S2); chk(f"R{ax}", R, R2, 1e-9*R2)
    chk("B2* sphere", B2star(1, 1, 1), 4, 1e-12)
    chk("B2* prolate/oblate symmetry", B2star(1, 1, 5), B2star(1, 1, .2), 1e-10)
    chk("B2* duality abc->1/a", B2star(1.25, 1, .8), B2star(.8, 1, 1.25), 1e-10)
    for ax in [(1, 1, 3.), (1, 1, .2), (1.25, 1, .8), (1, 2, 5)]:
        m, e = B2star_mc(ax, 40000 if fast else 200000)
        chk(f"B2* MC {ax}", m, B2star(*ax), 4*e)
        d = dilute(ax)
        chk(f"B2* kinetic quadrature {ax}", d['B2']/geometry(*ax)[0], B2star(*ax), 1e-4*B2star(*ax))
    h = 1e-3
    for nm, Z in (("CS", Z_CS), ("KLM", Z_KLM)):
        chk(f"{nm} B2 slope", (Z(h) - Z(-h))/(2*h), 4, 1e-3)
    vir = sum(c*(0.3)**k for k, c in enumerate(HS_VIRIAL))
    chk("KLM vs virial series at eta=0.3", Z_KLM(0.3), vir, 2e-3)
    chk("Z(rho=0.75) vs 6.6566 (hoomd-validation)", Z_KLM(0.75*pi/6), 6.6566, 5e-3)
    chk("Z(rho=0.60) vs 4.2952 (hoomd-validation)", Z_KLM(0.60*pi/6), 4.2952, 5e-3)
    chk("mean free time rho=.5 (Lue 2005 via DynamO test)", 1/enskog_rate(0.5), 0.13031, 2e-4)
    for f in (Z_parsons_lee, Z_vega, Z_nezbeda, Z_boublik, Z_song_mason):
        for ax in [(1, 1, 1), (1, 1, 3), (1, 2, 5)]:
            b2 = (f(1e-5, ax) - 1)/1e-5
            chk(f"{f.__name__} B2 {ax}", b2, B2star(*ax), 2e-3*B2star(*ax))
    d = dilute((.5, .5, .5))
    chk("dilute sphere rate", d['gamma'], 4*math.sqrt(pi), 1e-6)
    chk("dilute sphere VACF rate", d['nu_v'], 8/3*math.sqrt(pi), 1e-6)
    for ax in [(1, 1, 2.), (1.25, 1, .8)]:
        dt, dr = dilute(ax)['rates'](1.)
        chk(f"equilibrium detailed balance {ax}", dt, 0, 1e-9); chk(" rot", dr, 0, 1e-9)
        dd = dilute(ax); dt, dr = dd['rates'](0.9)
        chk(f"energy loss per collision = (1-e^2)kT {ax}", -(dt+dr)/(0.5*dd['gamma']), 1-.81, 1e-9)
    # crystals
    cell = fcc_stretched((1, 1.3, .6)); A = np.diag(np.array([1, 1.3, .6])**2)
    mn, cnt, ph = crystal_check(cell, [A], [np.zeros(3)], 3)
    chk("fcc stretched density", ph, pi/math.sqrt(18), 1e-12); chk("fcc contacts", cnt[0], 12, 0); chk("fcc min F", mn, 1, 1e-9)
    for (c, s) in ((1., 1.), (math.sqrt(3), 1.), (1., 1.5)):
        cell, A, B, tau, hh = sm2_crystal(c=c, s=s)
        mn, cnt, ph = crystal_check(cell, [A, B], [np.zeros(3), tau], 3)
        print("   SM2 axes", np.sqrt(np.linalg.eigvalsh(A)), np.sqrt(np.linalg.eigvalsh(B)), "h", hh)
        chk(f"SM2 density c={c:.3f} s={s}", ph, 0.770732, 2e-6); chk(" contacts", cnt[0], 14, 0); chk(" minF", mn, 1, 1e-9)
    # free rotation
    rng = np.random.default_rng(1)
    for I in ([1., 2., 3.3], [3., 1., 2.], [2., 3.1, 1.], [1.1, 1.0, 1.7]):
        w0 = rng.normal(size=3)
        t = 7.3
        from scipy.integrate import solve_ivp
        I = np.array(I)
        s = solve_ivp(lambda t, w: -np.cross(w, I*w)/I, (0, t), w0, rtol=1e-12, atol=1e-13, method='DOP853')
        e = np.abs(free_triaxial_omega(I, w0, t) - s.y[:, -1]).max()
        chk(f"triaxial top {I}", e, 0, 1e-8)
    # collision conservation
    ax1 = np.array([1, 1.5, 2.]); 
    R1 = quat_to_R(rng.normal(size=4)); R2 = quat_to_R(rng.normal(size=4))
    A, B = shape_matrix(ax1, R1), shape_matrix(ax1, R2)
    u = np.array([.3, -.5, .8]); F = pw(A, B, u)[0]; r = u/math.sqrt(F)
    F, l, n, xc = pw(A, B, r)
    I1 = 1/5*np.array([ax1[1]**2+ax1[2]**2, ax1[0]**2+ax1[2]**2, ax1[0]**2+ax1[1]**2])
    v1, w1, v2, w2 = rng.normal(size=(4, 3)); v1 = v1 + 3*n
    V1, W1, V2, W2, P = collide(1, I1, R1, v1, w1, xc, 1, I1, R2, v2, w2, xc - r, n)
    Il = lambda R: (R*I1) @ R.T
    E = lambda v, w, R: .5*v @ v + .5*w @ Il(R) @ w
    Lt = lambda v1, w1, v2, w2: Il(R1) @ w1 + Il(R2) @ w2 + np.cross(r, v2)
    chk("collision energy", E(V1, W1, R1)+E(V2, W2, R2), E(v1, w1, R1)+E(v2, w2, R2), 1e-12)
    chk("collision ang. mom.", np.abs(Lt(V1, W1, V2, W2) - Lt(v1, w1, v2, w2)).max(), 0, 1e-12)
    # growing collision: energy gain = g*P
    V1, W1, V2, W2, P, g = collide_growing(1, I1, R1, v1, w1, xc, 1, I1, R2, v2, w2, xc - r, n, 0.3)
    chk("LS collision energy gain = g P", E(V1, W1, R1)+E(V2, W2, R2)-E(v1, w1, R1)-E(v2, w2, R2), g*P, 1e-11)
    chk("rot fraction spheroid", rot_fraction_mean_std(1000, (1, 1, 3))[0], 2000/4997, 1e-12)
    f = brentq(lambda p: p*6/pi*Z_KLM(p) - 11.5727, .4, .52); sm = brentq(lambda p: p*6/pi*fcc_hall(p) - 11.5727, .53, .6)
    chk("freezing density at P*=11.5727", f, 0.4917, 5e-4); chk("melting density", sm, 0.5433, 5e-4)
    chk("free rotor C2 t->0 curvature", 2*(1-free_rotor_C((1, 1, 3.), 2, 1e-3))/1e-6, 6*2/2*1/((1+9)/5.), 1e-2)
    print(f"{sum(ok)}/{len(ok)} checks passed")
    return all(ok)

if __name__ == '__main__':
    import sys
    sys.exit(0 if selfcheck('--fast' in sys.argv) else 1)
