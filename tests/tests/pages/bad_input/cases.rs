//! The wrong scenes: name, what is changed, key, words of the message. `§` marks the line.

use crate::bad_input::Case;

macro_rules! cases {
    ($($name:literal: $($from:literal => $to:literal),+; $key:literal, $($word:literal),*;)*) => {
        &[$(Case { name: $name, change: &[$(($from, $to)),+], key: $key, words: &[$($word),*] },)*]
    };
}

pub(crate) const KEYS: &[Case] = cases! {
    "end missing": "until = 1.0\n" => ""; "until", "missing field", "until";
    "domain missing": "[domain]\n" => "", "geometry = \"space\"\n" => "",
        "lower = [0.0, 0.0, 0.0]\n" => "", "upper = [4.0, 4.0, 4.0]\n" => "", "cells = [32, 32, 32]\n" => "",
        "[domain.boundary]\nx = \"periodic\"\ny = \"periodic\"\nz_lower = \"no-slip\"\nz_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }\n" => "";
        "domain", "missing field";
    "geometry missing": "[domain]\ngeometry = \"space\"" => "§[domain]"; "domain.geometry", "missing field";
    "radius missing": "[[grains]]\nposition = [2.0, 2.0, 3.0]\nradius = 0.4" => "§[[grains]]\nposition = [2.0, 2.0, 3.0]";
        "grains[1].radius", "missing field";
    "unknown at the top": "until = 1.0" => "until = 1.0\n§untill = 2.0"; "untill", "unknown field";
    "unknown in domain": "cells = [32" => "§cell = 3\ncells = [32"; "domain.cell", "unknown field", "cells";
    "unknown in boundary": "y = \"periodic\"" => "y = \"periodic\"\n§w = \"periodic\""; "domain.boundary.w", "unknown field";
    "unknown in medium": "viscosity = 0.05" => "viscosity = 0.05\n§colour = 1"; "medium.colour", "unknown field";
    "unknown in a grain": "density = 4.0" => "density = 4.0\n§mass = 2.0"; "grains[0].mass", "unknown field", "density";
    "unknown in the second grain": "density = 3.0" => "density = 3.0\n§mass = 2.0"; "grains[1].mass", "unknown field";
    "unknown in a wall": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§thickness = 0.1"; "walls[0].thickness", "unknown field";
    "unknown in observe": "every = 0.1" => "every = 0.1\n§evry = 0.2"; "observe.evry", "unknown field";
    "unknown in metrics": "kind = \"max\"" => "kind = \"max\"\n§referense = 1.0"; "metrics[0].referense", "unknown field";
    "unknown in fluid": "[fluid.time]" => "[fluid]\n§solver = \"fast\"\n[fluid.time]"; "fluid.solver", "unknown field";
    "unknown in fluid.time": "cfl = 0.5" => "cfl = 0.5\n§clf = 0.4"; "fluid.time.clf", "unknown field", "cfl";
    "unknown in dem": "[dem]" => "[dem]\n§integrater = \"rk3\""; "dem.integrater", "unknown field";
    "unknown in dem.contact": "restitution = 0.9" => "restitution = 0.9\n§frction = 0.3"; "dem.contact.frction", "unknown field", "friction";
    "unknown in dem.lubrication": "cut_off = 0.4" => "cut_off = 0.4\n§cutoff = 0.3"; "dem.lubrication.cutoff", "unknown field";
    "unknown in coupling": "deadline = 5.0" => "deadline = 5.0\n§deadlin = 6.0"; "coupling.deadlin", "unknown field", "deadline";
    "text for a number": "until = 1.0" => "§until = \"one\""; "until", "string \"one\"", "f64";
    "truth for a radius": "radius = 0.5" => "§radius = true"; "grains[0].radius", "boolean";
    "two numbers for a position": "position = [2.0, 2.0, 1.0]" => "§position = [2.0, 1.0]"; "grains[0].position", "length 2";
    "text for a restitution": "restitution = 0.9" => "§restitution = \"high\""; "dem.contact.restitution", "string \"high\"";
    "text for a roughness": "roughness = 4e-4" => "§roughness = \"rough\""; "dem.lubrication.roughness", "string \"rough\"";
    "text for a metric's grain": "grain = 1" => "§grain = \"second\""; "metrics[1].grain", "string \"second\"";
    "number for a law": "law = \"linear-spring-dashpot\"" => "§law = 3"; "dem.contact.law", "3";
    "a key twice": "viscosity = 0.05" => "viscosity = 0.05\n§viscosity = 0.06"; "", "not valid TOML", "duplicate";
    "an open bracket": "lower = [0.0, 0.0, 0.0]" => "§lower = [0.0, 0.0 0.0]"; "", "not valid TOML";
    "no equals sign": "until = 1.0" => "§until 1.0"; "", "not valid TOML";
};

pub(crate) const BOXES: &[Case] = cases! {
    "no time": "until = 1.0" => "§until = 0.0"; "until", "is 0", "> 0";
    "time backwards": "until = 1.0" => "§until = -1.0"; "until", "is -1";
    "time without end": "until = 1.0" => "§until = inf"; "until", "is inf", "finite";
    "gravity not a number": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [0.0, nan, -1.0]"; "gravity", "NaN";
    "unknown geometry": "geometry = \"space\"" => "§geometry = \"spherical\""; "domain.geometry", "unknown variant", "axisymmetric";
    "two coordinates in space": "upper = [4.0, 4.0, 4.0]" => "§upper = [4.0, 4.0]"; "domain.upper", "2 numbers", "3 axes";
    "box inside out": "upper = [4.0, 4.0, 4.0]" => "§upper = [4.0, -4.0, 4.0]"; "domain.upper", "-4", "not above";
    "box without end": "upper = [4.0, 4.0, 4.0]" => "§upper = [4.0, 4.0, inf]"; "domain.upper", "inf";
    "two counts of cells": "cells = [32, 32, 32]" => "§cells = [32, 32]"; "domain.cells", "2 numbers";
    "cells missing": "cells = [32, 32, 32]" => "", "[domain]" => "§[domain]"; "domain.cells", "0 numbers";
    "one cell": "cells = [32, 32, 32]" => "§cells = [32, 1, 32]"; "domain.cells", "1 cells", "at least 4";
    "negative cells": "cells = [32, 32, 32]" => "§cells = [32, -32, 32]"; "domain.cells[1]", "-32";
    "absurd cells": "cells = [32, 32, 32]" => "§cells = [4000000, 4000000, 4000000]"; "domain.cells", "at most";
    "cells beyond any memory": "cells = [32, 32, 32]" => "§cells = [2000, 2000, 2000]"; "domain.cells", "GiB", "this machine";
    "cells that overflow": "cells = [32, 32, 32]" => "§cells = [9223372036854775807, 9223372036854775807, 4]"; "domain.cells", "at most";
    "a coarse grid": "cells = [32, 32, 32]" => "§cells = [32, 32, 4]"; "domain.cells", "fewer than 2 cells";
    "periodic on one side": "z_lower = \"no-slip\"" => "§z_lower = \"no-slip\"", "z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }" => "z_upper = \"periodic\"";
        "domain.boundary.z_lower", "not periodic";
    "a face missing": "[domain.boundary]" => "§[domain.boundary]", "z_lower = \"no-slip\"\n" => ""; "domain.boundary.z_lower", "is missing";
    "an axis without faces": "[domain.boundary]" => "§[domain.boundary]", "y = \"periodic\"\n" => ""; "domain.boundary.y", "is missing";
    "no faces at all": "[domain]" => "§[domain]", "[domain.boundary]\nx = \"periodic\"\ny = \"periodic\"\nz_lower = \"no-slip\"\nz_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }\n" => "";
        "domain.boundary", "missing field";
    "a face of a foreign axis": "y = \"periodic\"" => "y = \"periodic\"\n§r_upper = \"free-slip\""; "domain.boundary.r_upper", "axis r";
    "a pair and one of it": "z_lower = \"no-slip\"" => "z_lower = \"no-slip\"\n§z = \"no-slip\""; "domain.boundary.z", "both faces";
    "unknown boundary": "y = \"periodic\"" => "§y = \"sticky\""; "domain.boundary.y", "sticky", "no-slip";
    "inflow without velocity": "y = \"periodic\"" => "§y = \"inflow\""; "domain.boundary.y.velocity", "enters the box", "y above 0";
    "inflow that leaves": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, -1.0, 0.0] }\ny_upper = \"outflow\""; "domain.boundary.y_lower.velocity", "-1", "y above 0";
    "inflow that turns back": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = { amplitude = [0.0, 1.0, 0.0], frequency = 1.0, offset = [0.0, 0.5, 0.0] } }\ny_upper = \"outflow\""; "domain.boundary.y_lower.velocity", "between -0.5", "y above 0";
    "inflow from above that rises": "y = \"periodic\"" => "y_lower = \"outflow\"\n§y_upper = { type = \"inflow\", velocity = [0.0, 1.0, 0.0] }"; "domain.boundary.y_upper.velocity", "y below 0";
    "inflow not a number": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, nan, 0.0] }\ny_upper = \"outflow\""; "domain.boundary.y_lower.velocity", "NaN";
    "inflow without outflow": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, 1.0, 0.0] }\ny_upper = \"no-slip\""; "domain.boundary.y_lower", "no face is an outflow";
    "outflow without inflow": "y = \"periodic\"" => "y_lower = \"no-slip\"\n§y_upper = \"outflow\""; "domain.boundary.y_upper", "no face is an inflow";
    "inflow on a periodic axis": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, 1.0, 0.0] }\ny_upper = \"periodic\""; "domain.boundary.y_lower", "not periodic";
    "outflow on a periodic axis": "y = \"periodic\"" => "y_lower = \"periodic\"\n§y_upper = \"outflow\""; "domain.boundary.y_upper", "not periodic";
    "unknown profile": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, 1.0, 0.0], profile = \"jet\" }\ny_upper = \"outflow\""; "domain.boundary.y_lower.profile", "jet", "parabolic";
    "parabola that enters obliquely": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.5, 1.0, 0.0], profile = \"parabolic\" }\ny_upper = \"outflow\""; "domain.boundary.y_lower.velocity", "straight";
    "parabola without walls": "y = \"periodic\"" => "§y_lower = { type = \"inflow\", velocity = [0.0, 1.0, 0.0], profile = \"parabolic\" }\ny_upper = \"outflow\"", "z_lower = \"no-slip\"" => "z_lower = \"free-slip\"",
        "z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }" => "z_upper = \"free-slip\""; "domain.boundary.y_lower.profile", "no-slip wall";
    "profile of a wall": "z_lower = \"no-slip\"" => "§z_lower = { type = \"no-slip\", profile = \"parabolic\" }"; "domain.boundary.z_lower.profile", "nothing enters";
    "slabs without end": "every = 0.1" => "every = 0.1\n§profile = { lower = [0.0, 0.0, 0.0], upper = [1.0, 1.0, 1.0], slabs = 1000000000 }"; "observe.profile.slabs", "is 1000000000", "1 to 100000";
    "slabs beyond the box":
        "every = 0.1" => "every = 0.1\n§profile = { lower = [0.0, 0.0, 0.0], upper = [4.0, 5.0, 4.0], slabs = 4 }";
        "observe.profile", "0 to 5 m along y", "0 to 4 m";
    "outflow that drags": "y = \"periodic\"" => "y_lower = { type = \"inflow\", velocity = [0.0, 1.0, 0.0] }\n§y_upper = { type = \"outflow\", velocity = [1.0, 0.0, 0.0] }"; "domain.boundary.y_upper.velocity", "not no-slip";
    "flow rate between walls": "viscosity = 0.05" => "viscosity = 0.05\n§flow_rate = { axis = \"z\", mean_velocity = 1.0 }"; "medium.flow_rate.axis", "not periodic";
    "flow rate along a foreign axis": "viscosity = 0.05" => "viscosity = 0.05\n§flow_rate = { axis = \"r\", mean_velocity = 1.0 }"; "medium.flow_rate.axis", "R";
    "flow rate not a number": "viscosity = 0.05" => "viscosity = 0.05\n§flow_rate = { axis = \"x\", mean_velocity = nan }"; "medium.flow_rate.mean_velocity", "NaN";
    "flow rate and its gradient": "viscosity = 0.05" => "viscosity = 0.05\n§pressure_gradient = [-1.0, 0.0, 0.0]\nflow_rate = { axis = \"x\", mean_velocity = 1.0 }"; "medium.pressure_gradient", "flow rate is held";
    "number for a boundary": "y = \"periodic\"" => "§y = 3"; "domain.boundary.y", "3", "free-slip";
    "wall through itself": "z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }" => "§z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 1.0] }";
        "domain.boundary.z_upper.velocity", "through itself";
    "free slip that drags": "z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }" => "§z_upper = { type = \"free-slip\", velocity = [1.0, 0.0, 0.0] }";
        "domain.boundary.z_upper.velocity", "not no-slip";
    "wall velocity not a number": "z_upper = { type = \"no-slip\", velocity = [0.0, 0.0, 0.0] }" => "§z_upper = { type = \"no-slip\", velocity = [nan, 0.0, 0.0] }";
        "domain.boundary.z_upper.velocity", "NaN";
    "negative viscosity": "viscosity = 0.05" => "§viscosity = -0.05"; "medium.viscosity", "-0.05", "> 0";
    "weightless fluid": "[medium]\ndensity = 1.0" => "[medium]\n§density = 0.0"; "medium.density", "is 0";
    "pressure against a wall": "viscosity = 0.05" => "viscosity = 0.05\n§pressure_gradient = [0.0, 0.0, 1.0]"; "medium.pressure_gradient", "walls";
    "body force not a number": "viscosity = 0.05" => "viscosity = 0.05\n§body_force = [0.0, inf, 0.0]"; "medium.body_force", "inf";
    "unknown start": "initial = { type = \"rest\" }" => "§initial = { type = \"storm\" }"; "medium.initial.type", "storm", "taylor-green";
    "start without velocity": "initial = { type = \"rest\" }" => "§initial = { type = \"uniform\" }"; "medium.initial.velocity", "missing field";
    "shear along itself": "initial = { type = \"rest\" }" => "§initial = { type = \"shear\", direction = \"x\", gradient = \"x\", rate = 1.0, origin = 0.0 }";
        "medium.initial", "X";
    "shear along a foreign axis": "initial = { type = \"rest\" }" => "§initial = { type = \"shear\", direction = \"x\", gradient = \"r\", rate = 1.0, origin = 0.0 }";
        "medium.initial", "R";
    "stretching across space": "cells = [32, 32, 32]" => "cells = [32, 32, 32]\n§stretching = { axis = \"x\", uniform_to = 3.0, spacing = 0.125 }",
        "x = \"periodic\"" => "x = \"no-slip\"", "upper = [4.0, 4.0, 4.0]" => "upper = [8.0, 4.0, 4.0]"; "domain.stretching", "only the last axis";
};

pub(crate) const GRAINS: &[Case] = cases! {
    "negative radius": "radius = 0.5" => "§radius = -0.5"; "grains[0].radius", "-0.5", "> 0";
    "zero radius": "radius = 0.4" => "§radius = 0.0"; "grains[1].radius", "is 0";
    "radius not a number": "radius = 0.5" => "§radius = nan"; "grains[0].radius", "NaN";
    "density infinite": "density = 3.0" => "§density = inf"; "grains[1].density", "inf";
    "density negative": "density = 4.0" => "§density = -4.0"; "grains[0].density", "-4";
    "position infinite": "position = [2.0, 2.0, 1.0]" => "§position = [2.0, -inf, 1.0]"; "grains[0].position", "inf";
    "velocity not a number": "radius = 0.5" => "radius = 0.5\n§velocity = [nan, 0.0, 0.0]"; "grains[0].velocity", "NaN";
    "spin infinite": "radius = 0.5" => "radius = 0.5\n§spin = [0.0, inf, 0.0]"; "grains[0].spin", "inf";
    "overlapping grains": "position = [2.0, 2.0, 3.0]" => "§position = [2.0, 2.0, 1.6]"; "grains[1].position", "grains 0 and 1 overlap";
    "grains in one place": "position = [2.0, 2.0, 3.0]" => "§position = [2.0, 2.0, 1.0]"; "grains[1].position", "overlap";
    "overlap across a period": "position = [2.0, 2.0, 1.0]" => "position = [0.1, 2.0, 1.0]", "position = [2.0, 2.0, 3.0]" => "§position = [3.9, 2.0, 1.0]";
        "grains[1].position", "overlap";
    "grain behind a free-slip face": "x = \"periodic\"" => "x = \"free-slip\"", "position = [2.0, 2.0, 3.0]" => "locked = [\"x\"]\n§position = [3.8, 2.0, 3.0]"; "grains[1].position", "grain 1", "behind a free-slip face";
    "grain in a face": "position = [2.0, 2.0, 3.0]" => "§position = [2.0, 2.0, 3.9]"; "grains[1].position", "into the wall";
    "grain in a wall": "position = [2.0, 2.0, 1.0]" => "§position = [2.0, 2.0, 0.7]"; "grains[0].position", "into the wall";
    "grain outside": "position = [2.0, 2.0, 3.0]" => "§position = [5.0, 2.0, 3.0]"; "grains[1].position", "outside the box", "X";
    "long quaternion": "radius = 0.5" => "radius = 0.5\n§orientation = [1.0, 1.0, 0.0, 0.0]"; "grains[0].orientation", "norm";
    "disc in space": "radius = 0.5" => "radius = 0.5\n§shape = \"disc\""; "grains[0].shape", "disc";
    "rectangle": "radius = 0.5" => "radius = 0.5\n§shape = \"rectangle\""; "grains[0].shape", "rectangle", "sphere";
    "larger than the periodic box": "radius = 0.5" => "§radius = 2.1\nmotion = \"fixed\""; "grains[0].radius", "diameter 4.2", "larger than the periodic box";
    "held twice": "radius = 0.5\ndensity = 4.0" => "radius = 0.5\ndensity = 4.0\nmotion = \"fixed\"",
        "radius = 0.4" => "radius = 0.5\nmotion = \"fixed\"",
        "position = [2.0, 2.0, 3.0]" => "§position = [2.0, 2.0, 1.0]";
        "grains[1].position", "2 of 2 held grains", "as 0 and 1";
    "unknown motion": "radius = 0.5" => "radius = 0.5\n§motion = \"dancing\""; "grains[0].motion", "dancing", "prescribed";
    "swing of a free grain": "radius = 0.5" => "radius = 0.5\n§velocity = { amplitude = [0.0, 0.0, 1.0], frequency = 1.0 }"; "grains[0].velocity", "not prescribed";
    "swing under its old name": "radius = 0.5" => "radius = 0.5\n§oscillation = { amplitude = [0.0, 0.0, 1.0], frequency = 1.0 }"; "grains[0].oscillation", "retired";
    "driven through a wall": "radius = 0.5" => "radius = 0.5\nmotion = \"prescribed\"\n§velocity = [0.0, 0.0, -2.0]";
        "grains[0].velocity", "through a wall", "at z = -0.5";
    "swing without frequency": "radius = 0.5" => "radius = 0.5\nmotion = \"prescribed\"\n§velocity = { amplitude = [0.0, 0.0, 1.0], frequency = 0.0 }";
        "grains[0].velocity.frequency", "is 0";
    "swing of a negative frequency": "gravity = [0.0, 0.0, -1.0]" => "§gravity = { amplitude = [0.0, 0.0, 1.0], frequency = -2.0 }"; "gravity.frequency", "-2";
    "swing that is not finite": "gravity = [0.0, 0.0, -1.0]" => "§gravity = { amplitude = [0.0, 0.0, inf], frequency = 2.0 }"; "gravity", "inf";
    "table without rows": "gravity = [0.0, 0.0, -1.0]" => "§gravity = []"; "gravity", "no rows";
    "table whose times go back": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [[1.0, [0.0, 0.0, 0.0]], [1.0, [0.0, 0.0, -1.0]]]"; "gravity", "row 2";
    "table without a value": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [[1.0, [0.0, nan, 0.0]]]"; "gravity", "NaN";
    "table in no file": "gravity = [0.0, 0.0, -1.0]" => "§gravity = { file = \"nowhere.csv\" }"; "gravity", "nowhere.csv";
    "table and sine": "gravity = [0.0, 0.0, -1.0]" => "§gravity = { file = \"a.csv\", frequency = 1.0 }"; "gravity", "give one";
    "unknown lock": "radius = 0.5" => "radius = 0.5\n§locked = [\"x\", \"roll\"]"; "grains[0].locked[1]", "roll", "spin-x";
    "wall without normal": "normal = [0.0, 0.0, 1.0]" => "§normal = [0.0, 0.0, 0.0]"; "walls[0].normal", "0.0";
    "wall nowhere": "point = [0.0, 0.0, 0.25]" => "§point = [0.0, 0.0, nan]"; "walls[0].point", "NaN";
    "wall until never a number": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§until = nan"; "walls[0].until", "NaN";
    "wall about no axis": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§about = [0.0, 0.0, 1.0]"; "walls[0].about", "does not turn";
    "wall that turns across a period": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§spin = [0.0, 0.0, 1.0]"; "walls[0].spin", "x is periodic";
    "wall about two axes": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§spin = [[0.0, [1.0, 0.0, 0.0]], [1.0, [0.0, 1.0, 0.0]]]"; "walls[0].spin", "axis that changes";
    "servo without a limit": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§servo = { pressure = 1.0 }"; "walls[0].servo.largest_speed", "missing";
    "servo of a force": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§servo = { force = 1.0, largest_speed = 1.0 }"; "walls[0].servo.force", "pressure";
    "servo at no speed": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§servo = { pressure = 1.0, largest_speed = 0.0 }"; "walls[0].servo.largest_speed", "> 0";
    "servo that pulls": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§servo = { pressure = -1.0, largest_speed = 1.0 }"; "walls[0].servo.pressure", "-1";
    "servo without area": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\n§servo = { pressure = 1.0, largest_speed = 1.0, area = 0.0 }"; "walls[0].servo.area", "> 0";
    "servo that is moved": "normal = [0.0, 0.0, 1.0]" => "normal = [0.0, 0.0, 1.0]\nservo = { pressure = 1.0, largest_speed = 1.0 }\n§velocity = [0.1, 0.0, 0.1]"; "walls[0].velocity", "servo";
    "layer on no wall": "[[walls]]" => "[[rough_walls]]\nlower = [0.0, 0.0, 4.0]\nupper = [4.0, 4.0, 4.0]\nradius = 0.5\ndensity = 1.0\n§wall = 1\n[[walls]]"; "rough_walls[0].wall", "is 1";
    "wall across a period": "[[walls]]\npoint = [0.0, 0.0, 0.25]\nnormal = [0.0, 0.0, 1.0]" => "§[[walls]]\npoint = [0.0, 0.0, 0.25]\nnormal = [0.1, 0.0, 1.0]"; "walls[0]", "periodic";
    "group without radius": "[[walls]]" => "§[[groups]]\ncount = 1\nlower = [0.0, 0.0, 1.0]\nupper = [4.0, 4.0, 2.0]\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0].radius", "missing field";
    "group in a slot": "[[walls]]" => "[[groups]]\ncount = 1\nlower = [0.0, 0.0, 1.6]\n§upper = [4.0, 4.0, 2.0]\nradius = 0.25\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0].upper", "no room", "0.5";
    "group too full": "[[walls]]" => "§[[groups]]\ncount = 500\nlower = [0.0, 0.0, 1.6]\nupper = [4.0, 4.0, 2.6]\nradius = 0.25\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0]", "no room for grain", "of 500";
    "group outside": "[[walls]]" => "§[[groups]]\ncount = 1\nlower = [5.0, 0.0, 1.6]\nupper = [6.0, 4.0, 2.6]\nradius = 0.25\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0]", "outside the box";
    "group of everything": "[[walls]]" => "§[[groups]]\ncount = 9000000000000000000\nlower = [0.0, 0.0, 1.6]\nupper = [4.0, 4.0, 2.6]\nradius = 0.25\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups", "more than";
    "spread of one": "[[walls]]" => "[[groups]]\ncount = 1\nlower = [0.0, 0.0, 1.6]\nupper = [4.0, 4.0, 2.6]\nradius = 0.25\n§radius_spread = 1.0\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0].radius_spread", "is 1";
    "spread not a number": "[[walls]]" => "[[groups]]\ncount = 1\nlower = [0.0, 0.0, 1.6]\nupper = [4.0, 4.0, 2.6]\nradius = 0.25\n§radius_spread = nan\ndensity = 2.0\nseed = 1\n[[walls]]"; "groups[0].radius_spread", "NaN";
    "file of grains missing": "[[walls]]" => "[[grain_files]]\n§file = \"no/such/file.csv\"\n[[walls]]"; "grain_files[0].file", "cannot read", "no/such/file.csv";
};

pub(crate) const SECTIONS: &[Case] = cases! {
    "fluid step negative": "dt = 0.01" => "§dt = -0.01"; "fluid.time.dt", "-0.01", "> 0";
    "fluid step not a number": "dt = 0.01" => "§dt = nan"; "fluid.time.dt", "NaN";
    "fluid step that changes no time": "dt = 0.01" => "§dt = 1e-300"; "fluid.time.dt", "1e-300", "change a time";
    "cfl too large": "cfl = 0.5" => "§cfl = 9.0"; "fluid.time.cfl", "is 9", "up to";
    "unknown scheme": "cfl = 0.5" => "cfl = 0.5\n§scheme = \"rk4\""; "fluid.time.scheme", "rk4", "ab2";
    "levels of the step": "cfl = 0.5" => "cfl = 0.5\n§dt_levels_per_octave = 4"; "fluid.time.dt_levels_per_octave", "retired", "no such choice";
    "explicit viscosity, long step": "dt = 0.01" => "§dt = 0.2\nviscosity = \"explicit\""; "fluid.time.dt", "0.2", "explicit";
    "width of the mask": "[dem]" => "[fluid.immersed]\n§width = 0.5\n[dem]"; "fluid.immersed.width", "retired", "no such choice";
    "unknown method": "[dem]" => "[fluid]\n§method = \"sharp\"\n[dem]"; "fluid.method", "sharp", "calibrated";
    "former name of the printed method": "[dem]" => "[fluid.immersed]\n§method = \"direct\"\n[dem]"; "fluid.immersed.method", "retired", "izard-2014";
    "the printed loads of a neutral grain": "density = 3.0" => "density = 1.0", "[dem]" => "[fluid]\n§method = \"izard-2014\"\n[dem]";
        "fluid.method", "grain 1", "izard-2014";
    "form of the loads": "[dem]" => "[fluid.loads]\n§form = \"uhlmann-2005\"\n[dem]"; "fluid.loads.form", "retired", "no such choice";
    "command as one word": "[fluid.time]" => "[fluid]\n§command = \"my-solver\"\n[fluid.time]"; "fluid.command", "string", "sequence";
    "contact missing": "[dem]" => "§[dem]", "[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 0.02\n" => ""; "dem.contact", "is missing";
    "dem missing": "[dem]\nintegrator = \"symplectic-euler\"\n" => "", "[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 0.02\n" => "",
        "[dem.lubrication]\nform = \"as-printed\"\nroughness = 4e-4\ncut_off = 0.4\n" => ""; "dem.contact", "is missing";
    "unknown law": "law = \"linear-spring-dashpot\"" => "§law = \"hertz\""; "dem.contact.law", "hertz", "linear-spring-dashpot";
    "law missing": "[dem.contact]\nlaw = \"linear-spring-dashpot\"" => "§[dem.contact]"; "dem.contact.law", "missing field";
    "contact time missing": "[dem.contact]" => "§[dem.contact]", "contact_time = 0.02\n" => ""; "dem.contact.contact_time", "is missing", "stiffness";
    "restitution zero": "restitution = 0.9" => "§restitution = 0.0"; "dem.contact.restitution", "is 0", "above 0";
    "restitution above one": "restitution = 0.9" => "§restitution = 1.1"; "dem.contact.restitution", "1.1", "at most 1";
    "restitution out of the exact form": "restitution = 0.9" => "§restitution = 0.1\nform = \"exact-restitution\""; "dem.contact.restitution", "0.1", "0.1355";
    "contact time zero": "contact_time = 0.02" => "§contact_time = 0.0"; "dem.contact.contact_time", "is 0";
    "contact time infinite": "contact_time = 0.02" => "§contact_time = inf"; "dem.contact.contact_time", "inf";
    "negative friction": "contact_time = 0.02" => "contact_time = 0.02\n§friction = -0.3"; "dem.contact.friction", "-0.3";
    "softness zero": "law = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = 0.02" => "law = \"wan-turek\"\n§softness = 0.0\nwall_softness = 1.0\nrange = 0.1";
        "dem.contact.softness", "is 0";
    "unknown film": "form = \"as-printed\"" => "§form = \"thin\""; "dem.lubrication.form", "thin", "complement";
    "smooth grains": "roughness = 4e-4" => "§roughness = 0.0"; "dem.lubrication.roughness", "is 0";
    "roughness missing": "[dem.lubrication]" => "§[dem.lubrication]", "roughness = 4e-4\n" => ""; "dem.lubrication.roughness", "missing field";
    "no cut-off": "cut_off = 0.4" => "§cut_off = 0.0"; "dem.lubrication.cut_off", "is 0";
    "retired sweeps": "cut_off = 0.4" => "cut_off = 0.4\n§sweeps = 4"; "dem.lubrication.sweeps", "retired", "no such choice";
    "retired film": "form = \"as-printed\"" => "§form = \"continuous\""; "dem.lubrication.form", "retired", "complement";
    "film longer than the box": "upper = [4.0, 4.0, 4.0]" => "§upper = [4.0, 4.0, 4.0]", "cut_off = 0.4" => "cut_off = 3.0"; "domain.upper", "along x is 4 m";
    "unknown integrator": "integrator = \"symplectic-euler\"" => "§integrator = \"leapfrog\""; "dem.integrator", "leapfrog", "velocity-verlet";
    "rk3 with a film": "integrator = \"symplectic-euler\"" => "§integrator = \"rk3\""; "dem.integrator", "rk3", "implicit";
    "sub-step negative": "[dem]" => "[dem]\n§dt = -1e-4"; "dem.dt", "-0.0001", "> 0";
    "film of another method": "[dem]" => "[dem]\n§line_film = \"points\""; "dem.line_film", "points", "mask";
    "sub-step that changes no time": "[dem]" => "[dem]\n§dt = 1e-300"; "dem.dt", "1e-300", "change a time";
    "no sub-steps": "[dem]" => "[dem]\n§steps_per_contact = 0.0"; "dem.steps_per_contact", "is 0";
    "retired skin": "[dem]" => "[dem]\n§skin = 0.1"; "dem.skin", "retired", "no such choice";
    "scheme that the loads cannot follow": "deadline = 5.0" => "deadline = 5.0\n§scheme = \"explicit\""; "coupling.scheme", "explicit", "semi-implicit";
    "an order that the method cannot follow": "deadline = 5.0" => "deadline = 5.0\n§scheme = \"iterated\"", "[dem]" => "[fluid]\nmethod = \"izard-2014\"\n[dem]"; "coupling.scheme", "is iterated", "explicit";
    "scheme that is none": "deadline = 5.0" => "deadline = 5.0\n§scheme = \"implicit\""; "coupling.scheme", "implicit", "iterated";
    "former order of the exchange": "deadline = 5.0" => "deadline = 5.0\n§scheme = \"overlapped\""; "coupling.scheme", "retired", "semi-implicit";
    "no tolerance": "deadline = 5.0" => "deadline = 5.0\n§iterations = { tolerance = 0.0 }"; "coupling.iterations.tolerance", "is 0";
    "one attempt": "deadline = 5.0" => "deadline = 5.0\niterations.§max_iterations = 1"; "coupling.iterations.max_iterations", "is 1";
    "unknown bound": "deadline = 5.0" => "deadline = 5.0\n§force = [\"luck\"]"; "coupling.force", "luck", "contact-steps";
    "no deadline": "deadline = 5.0" => "§deadline = 0.0"; "coupling.deadline", "is 0";
    "no sub-steps of the coupler": "deadline = 5.0" => "deadline = 5.0\n§steps_per_contact = -5.0"; "coupling.steps_per_contact", "-5";
    "checkpoints backwards": "deadline = 5.0" => "deadline = 5.0\n§checkpoint_every = -1.0"; "coupling.checkpoint_every", "-1";
};

pub(crate) const OBSERVATIONS: &[Case] = cases! {
    "rows backwards": "every = 0.1" => "§every = -0.1"; "observe.every", "-0.1";
    "fields never": "every = 0.1" => "every = 0.1\n§fields_at = [0.1, nan]"; "observe.fields_at", "NaN";
    "fields before the start": "every = 0.1" => "every = 0.1\n§fields_at = [0.1, -1.0]"; "observe.fields_at", "-1";
    "no total": "every = 0.1" => "every = 0.1\n§totals = { columns = [] }"; "observe.totals.columns", "no column";
    "a total twice": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"bed-height\", \"bed-height\"] }"; "observe.totals.columns", "twice";
    "unknown total": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"height\"] }"; "observe.totals.columns[0]", "unknown variant", "bed-height";
    "a bed across a periodic axis": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"bed-height\"], axis = \"x\" }"; "observe.totals.axis", "\"x\"", "no wall";
    "a surface without solid": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"bed-height\"], surface = 0.0 }"; "observe.totals.surface", "is 0", "between 0 and 1";
    "moving grains without a speed": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"moving-grains\"] }"; "observe.totals.speed", "not given";
    "a speed below zero": "every = 0.1" => "every = 0.1\n§totals = { columns = [\"moving-grains\"], speed = -1.0 }"; "observe.totals.speed", "is -1";
    "stresses across a periodic axis": "every = 0.1" => "every = 0.1\n§planes = { every = 0.1, axis = \"y\", stress = true }"; "observe.planes.axis", "no wall";
    "stresses of another method": "every = 0.1" => "every = 0.1\n§planes = { every = 0.1, stress = true }", "[fluid.time]" => "[fluid]\nmethod = \"izard-2014\"\n[fluid.time]"; "observe.planes.stress", "does not keep";
    "a Shields number without weight": "gravity = [0.0, 0.0, -1.0]" => "gravity = [0.0, 0.0, 0.0]", "every = 0.1" => "every = 0.1\n§totals = { columns = [\"shields\"] }"; "observe.totals.columns", "nothing has a weight";
    "observed grain that is not there": "every = 0.1" => "every = 0.1\n§grains = [0, 2]"; "observe.grains", "holds 2", "2 grains";
    "unknown kind": "kind = \"max\"" => "§kind = \"median\""; "metrics[0].kind", "median", "terminal-reynolds";
    "more than all grains": "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"mobilisation-time\"\nspeed = 0.1\n§share = 2.0"; "metrics[0].share", "is 2", "up to 1";
    "kind missing": "[[metrics]]\nname = \"speed\"\nkind = \"max\"" => "§[[metrics]]\nname = \"speed\""; "metrics[0].kind", "missing field";
    "unknown column": "column = \"velocity_z[0]\"" => "§column = \"speed_z[0]\""; "metrics[0].column", "speed_z[0]", "velocity_z[0]";
    "column missing": "[[metrics]]\nname = \"speed\"" => "§[[metrics]]\nname = \"speed\"", "column = \"velocity_z[0]\"\n" => ""; "metrics[0].column", "missing field";
    "metric of a grain that is not there": "grain = 1" => "§grain = 7"; "metrics[1].grain", "is 7", "2 grains";
    "a metric's name is a whole path": "name = \"speed\"" => "§name = \"/tmp/speed\"", "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.0, 0.0, 0.0]\nfile = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].name", "becomes the file", "letters";
    "a metric's name leads out of the folder": "name = \"speed\"" => "§name = \"../../speed\"", "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.0, 0.0, 0.0]\nfile = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].name", "becomes the file", "not beginning with";
    "a metric's name is a file of the folder": "name = \"speed\"" => "§name = \"series\"", "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.0, 0.0, 0.0]\nfile = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].name", "series.csv is a file of the output folder";
    "a metric's name begins with a point": "name = \"speed\"" => "§name = \".speed\"", "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.0, 0.0, 0.0]\nfile = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].name", "becomes the file";
    "two metrics with one name": "name = \"reynolds\"" => "§name = \"speed\""; "metrics[1].name", "second time";
    "table of velocities missing": "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.0, 0.0, 0.0]\n§file = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].file", "no/such.csv", "cannot be read";
    "published course missing": "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "kind = \"series-difference\"\n§file = \"no/such.csv\"\ncolumn = \"velocity_z[0]\""; "metrics[0].file", "no/such.csv", "cannot read";
    "velocity along a foreign axis": "kind = \"max\"\ncolumn = \"velocity_z[0]\"" => "§kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"r\"\nthrough = [0.0, 0.0, 0.0]\nfile = \"no/such.csv\"\ncolumn = \"u\""; "metrics[0].kind", "x along r";
    "mean from an unknown test": "kind = \"max\"" => "kind = \"mean\"\n§from = \"steady\""; "metrics[0].from", "steady", "stationary";
    "mean from before": "kind = \"max\"" => "kind = \"mean\"\n§from = -1.0"; "metrics[0].from", "-1";
    "frequency from before": "kind = \"max\"" => "kind = \"frequency\"\n§from = -1.0"; "metrics[0].from", "-1";
    "rebound below the surface": "kind = \"terminal-reynolds\"" => "kind = \"restitution-at-gap\"\n§gap = -0.1"; "metrics[1].gap", "-0.1";
};

pub(crate) const ON_AN_AXIS: &[Case] = cases! {
    "grain off the axis": "position = [0.0, 0.0, 6.0]" => "§position = [1.0, 0.0, 6.0]"; "grains[0].position", "off the axis";
    "gravity across the axis": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [1.0, 0.0, 0.0]"; "gravity", "axis of symmetry";
    "hollow cylinder": "lower = [0.0, 0.0]" => "§lower = [1.0, 0.0]"; "domain.lower", "r = 1";
    "inflow through the cylinder": "r_upper = \"free-slip\"" => "§r_upper = { type = \"inflow\", velocity = [-1.0, 0.0, 0.0] }"; "domain.boundary.r_upper", "outer cylinder";
    "inflow that swirls": "z = \"free-slip\"" => "§z_lower = { type = \"inflow\", velocity = [0.0, 1.0, 1.0] }\nz_upper = \"outflow\""; "domain.boundary.z_lower.velocity", "Axisymmetric";
    "periodic cylinder": "r_upper = \"free-slip\"" => "§r_upper = \"periodic\""; "domain.boundary.r_upper", "periodic";
    "cylinder missing": "[domain.boundary]\nr_upper = \"free-slip\"" => "§[domain.boundary]"; "domain.boundary.r_upper", "is missing";
    "group on an axis": "[fluid.time]" => "§[[groups]]\ncount = 1\nlower = [-2.0, -2.0, 1.0]\nupper = [2.0, 2.0, 4.0]\nradius = 0.5\ndensity = 2.0\nseed = 1\n[fluid.time]"; "groups[0]", "axis";
    "stretching a foreign axis": "axis = \"r\"" => "§axis = \"y\""; "domain.stretching.axis", "Y";
    "stretching an unknown axis": "axis = \"r\"" => "§axis = \"q\""; "domain.stretching.axis", "q";
    "stretching a period": "axis = \"r\"" => "§axis = \"z\"", "z = \"free-slip\"" => "z = \"periodic\""; "domain.stretching.axis", "periodic";
    "stretching both metrics": "stretching = { axis = \"r\", uniform_to = 1.5, spacing = 0.1 }" => "§stretching = { axis = \"z\", uniform_to = 7.0, spacing = 0.09090909090909091 }";
        "domain.stretching", "both stretched or radial", "allows one";
    "stretching without spacing": "spacing = 0.1" => "§spacing = 0.0"; "domain.stretching.spacing", "is 0";
    "uniform part of broken cells": "uniform_to = 1.5" => "§uniform_to = 1.55"; "domain.stretching.uniform_to", "15.5";
    "uniform part beyond the box": "uniform_to = 1.5" => "§uniform_to = 9.0"; "domain.stretching", "do not reach";
    "stretching with too many cells": "spacing = 0.1" => "§spacing = 0.5"; "domain.stretching", "32 cells do not reach";
    "averages over boxes of a cylinder": "[fluid.time]" => "[observe]\n§profile = { axis = \"z\", lower = [0.0, 0.0, 0.0], upper = [1.0, 1.0, 1.0], slabs = 5 }\n[fluid.time]"; "observe.profile", "cylinder";
    "stresses in a cylinder": "[fluid.time]" => "[observe]\n§planes = { every = 0.1, axis = \"z\", stress = true }\n[fluid.time]", "z = \"free-slip\"" => "z = \"no-slip\""; "observe.planes.axis", "axisymmetric";
    "uniform part too short": "uniform_to = 1.5" => "§uniform_to = 0.4"; "domain.stretching.uniform_to", "grain 0 reaches to 0.5";
};

pub(crate) const IN_A_PLANE: &[Case] = cases! {
    "outflow of nothing": "z_upper = \"free-slip\"" => "§z_upper = \"outflow\""; "domain.boundary.z_upper", "no fluid";
    "grain out of the plane": "position = [10.0, 0.0, 19.0]" => "§position = [10.0, 1.0, 19.0]"; "grains[0].position", "out of the plane";
    "gravity out of the plane": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [0.0, -1.0, 0.0]"; "gravity", "out of the plane";
    "gravity that leaves the plane": "gravity = [0.0, 0.0, -1.0]" => "§gravity = [[0.0, [0.0, 0.0, -1.0]], [1.0, [0.0, 2.0, -1.0]]]"; "gravity", "out of the plane";
    "three coordinates in a plane": "upper = [20.0, 20.0]" => "§upper = [20.0, 1.0, 20.0]"; "domain.upper", "3 numbers";
    "group in a grain": "position = [10.0, 0.0, 19.0]" => "position = [5.0, 0.0, 5.0]", "[[groups]]\ncount = 20" => "§[[groups]]\ncount = 200";
        "groups[0]", "no room";
    "rolling without friction":
        "contact_time = 0.01" => "contact_time = 0.01\nfriction = 0.3\n§rolling = { damping = 0.1 }";
        "dem.contact.rolling.friction", "missing field";
    "complement without fluid":
        "[dem.contact]" => "§[dem.lubrication]\nform = \"complement\"\nroughness = 1e-3\n[dem.contact]";
        "dem.lubrication", "dry";
    "film without fluid": "[dem.contact]" => "§[dem.lubrication]\nform = \"as-printed\"\nroughness = 1e-3\n[dem.contact]"; "dem.lubrication", "dry";
    "a flux of no fluid": "[dem.contact]" => "[observe]\n§totals = { columns = [\"fluid-flux\"] }\n[dem.contact]"; "observe.totals.columns", "the scene has none";
    "with a fluid that is not there": "position = [10.0, 0.0, 19.0]" => "position = [10.0, 0.0, 19.0]\n§with_fluid = true"; "grains[0].with_fluid", "does not say";
    "neither fluid nor grains": "[[grains]]\nposition = [10.0, 0.0, 19.0]\nradius = 0.5\ndensity = 2.5\n" => "",
        "[[groups]]\ncount = 20\nlower = [1.0, 0.0, 0.0]\nupper = [9.0, 0.0, 9.0]\nradius = 0.5\nradius_spread = 0.1\ndensity = 2.5\nseed = 7\n" => "";
        "grains", "neither fluid nor grains";
};
