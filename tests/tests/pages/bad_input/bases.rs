//! Scenes that are right; every wrong one is one of these with a small change.

/// Two spheres one above the other in a box that is periodic along x and y.
pub(crate) const SPACE: &str = r#"title = "two spheres"
until = 1.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [32, 32, 32]

[domain.boundary]
x = "periodic"
y = "periodic"
z_lower = "no-slip"
z_upper = { type = "no-slip", velocity = [0.0, 0.0, 0.0] }

[medium]
density = 1.0
viscosity = 0.05
initial = { type = "rest" }

[[grains]]
position = [2.0, 2.0, 1.0]
radius = 0.5
density = 4.0

[[grains]]
position = [2.0, 2.0, 3.0]
radius = 0.4
density = 3.0

[[walls]]
point = [0.0, 0.0, 0.25]
normal = [0.0, 0.0, 1.0]

[fluid.time]
dt = 0.01
cfl = 0.5

[dem]
integrator = "symplectic-euler"

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02

[dem.lubrication]
form = "as-printed"
roughness = 4e-4
cut_off = 0.4

[coupling]
deadline = 5.0

[observe]
every = 0.1

[[metrics]]
name = "speed"
kind = "max"
column = "velocity_z[0]"

[[metrics]]
name = "reynolds"
kind = "terminal-reynolds"
grain = 1
"#;

/// A sphere on the axis, the radial axis stretched.
pub(crate) const AXIS: &str = r#"until = 1.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [8.0, 8.0]
cells = [32, 80]
stretching = { axis = "r", uniform_to = 1.5, spacing = 0.1 }

[domain.boundary]
r_upper = "free-slip"
z = "free-slip"

[medium]
density = 1.0
viscosity = 0.05

[[grains]]
position = [0.0, 0.0, 6.0]
radius = 0.5
density = 4.0

[fluid.time]
dt = 0.02
"#;

/// Dry discs in a trough.
pub(crate) const PLANE: &str = r#"until = 1.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [20.0, 20.0]

[domain.boundary]
x = "no-slip"
z_lower = "no-slip"
z_upper = "free-slip"

[[grains]]
position = [10.0, 0.0, 19.0]
radius = 0.5
density = 2.5

[[groups]]
count = 20
lower = [1.0, 0.0, 0.0]
upper = [9.0, 0.0, 9.0]
radius = 0.5
radius_spread = 0.1
density = 2.5
seed = 7

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.01
"#;
