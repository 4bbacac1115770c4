//! Outlines of bodies of the plane that are not round: ellipses and convex polygons.
//!
//! Frame of the body: axes (x, z) that lie along those of the laboratory at orientation (1, 0, 0, 0), the
//! origin in the centre of mass.

use std::f64::consts::PI;

/// Outline of a body about its centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Ellipse with its semi-axes along x and z, m.
    Ellipse {
        /// Semi-axes, m.
        semi_axes: [f64; 2],
    },
    /// Convex polygon, its vertices (x, z) turning from x to z, m.
    Polygon {
        /// Vertices, m.
        vertices: Vec<[f64; 2]>,
    },
}

/// a_x b_z − a_z b_x.
#[inline(always)]
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// a − b.
#[inline(always)]
pub fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// a · b.
#[inline(always)]
pub fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// |a|.
#[inline(always)]
pub fn length(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

impl Outline {
    /// Most vertices of a polygon.
    pub const MOST_VERTICES: usize = 64;

    /// Points along an ellipse, as pictures have it.
    const ALONG_ELLIPSE: u32 = 64;

    /// Points (x, z) around it, m, between which pictures draw lines.
    pub fn corners(&self) -> Vec<[f64; 2]> {
        let angle = |k: u32| 2.0 * PI * f64::from(k) / f64::from(Self::ALONG_ELLIPSE);
        match self {
            Self::Ellipse { semi_axes: [a, b] } => {
                (0..Self::ALONG_ELLIPSE).map(angle).map(|t| [a * t.cos(), b * t.sin()]).collect()
            }
            Self::Polygon { vertices } => vertices.clone(),
        }
    }

    /// A rectangle with `sides` along x and z, m.
    pub fn rectangle([along_x, along_z]: [f64; 2]) -> Self {
        let (a, b) = (0.5 * along_x, 0.5 * along_z);
        Self::Polygon { vertices: vec![[-a, -b], [a, -b], [a, b], [-a, b]] }
    }

    /// A convex polygon, moved so that its centre of mass is the origin. Vertices may turn either way.
    ///
    /// # Errors
    /// What is wrong with vertices that make no convex body, and what to do.
    pub fn polygon(vertices: &[[f64; 2]]) -> Result<Self, (String, &'static str)> {
        const IN_ORDER: &str = "name the vertices in order around the body";
        let (count, most) = (vertices.len(), Self::MOST_VERTICES);
        if !(3..=most).contains(&count) {
            let remedy = if count < 3 { "add vertices" } else { "leave some out" };
            return Err((format!("has {count} of them; allowed: 3 to {most}"), remedy));
        }
        if let Some(k) = vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            let what = format!("[{k}] is {:?}; allowed: finite numbers", vertices[k]);
            return Err((what, "give finite numbers, m"));
        }
        let mut vertices = vertices.to_vec();
        let size = vertices.iter().map(|v| length(minus(*v, vertices[0]))).fold(0.0, f64::max);
        let edge = |vertices: &[[f64; 2]], k: usize| minus(vertices[(k + 1) % count], vertices[k % count]);
        if let Some(k) = (0..count).find(|k| length(edge(&vertices, *k)) <= 1e-9 * size) {
            let what = format!("[{k}] and the next one coincide at {:?}", vertices[k]);
            return Err((what, "name each vertex once; the last one joins the first by itself"));
        }
        let crossing = || ("are joined by edges that cross each other".to_owned(), IN_ORDER);
        let (area, _) = area_and_centre(&vertices);
        if area.abs() <= 1e-9 * size * size {
            let turns = (0..count)
                .any(|k| cross(edge(&vertices, k), edge(&vertices, k + 1)).abs() > 1e-9 * size * size);
            let flat =
                ("lie on a line: the body has no area".to_owned(), "give vertices that enclose an area");
            return Err(if turns { crossing() } else { flat });
        }
        if area < 0.0 {
            vertices.reverse();
        }
        let mut turned = 0.0;
        for k in 0..count {
            let (one, next) = (edge(&vertices, k), edge(&vertices, k + 1));
            let turn = cross(one, next).atan2(dot(one, next));
            if turn <= 0.0 {
                return Err((
                    "do not turn the same way everywhere: the outline is not convex".to_owned(),
                    "name the vertices in order around the body, none on the line of its neighbours; bodies with \
                     re-entrant corners are not supported",
                ));
            }
            turned += turn;
        }
        if turned > 3.0 * PI {
            return Err(crossing());
        }
        let (_, centre) = area_and_centre(&vertices);
        vertices.iter_mut().for_each(|v| *v = minus(*v, centre));
        Ok(Self::Polygon { vertices })
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        match self {
            Self::Ellipse { semi_axes: [a, b] } => PI * a * b,
            Self::Polygon { vertices } => area_and_centre(vertices).0,
        }
    }

    /// Moment of inertia about the centre of mass over mass, m².
    pub fn gyration(&self) -> f64 {
        match self {
            Self::Ellipse { semi_axes: [a, b] } => 0.25 * (a * a + b * b),
            Self::Polygon { vertices } => {
                let second: f64 = pairs(vertices)
                    .map(|(p, q)| cross(p, q) * (dot(p, p) + dot(p, q) + dot(q, q)) / 12.0)
                    .sum();
                second / self.area()
            }
        }
    }

    /// Largest distance of the surface from the centre of mass, m.
    pub fn reach(&self) -> f64 {
        match self {
            Self::Ellipse { semi_axes: [a, b] } => a.max(*b),
            Self::Polygon { vertices } => vertices.iter().map(|v| length(*v)).fold(0.0, f64::max),
        }
    }

    /// Least width between two parallel lines, m.
    pub fn thickness(&self) -> f64 {
        match self {
            Self::Ellipse { semi_axes: [a, b] } => 2.0 * a.min(*b),
            Self::Polygon { vertices } => {
                let width = |(p, q): ([f64; 2], [f64; 2])| {
                    let along = minus(q, p);
                    let far = vertices.iter().map(|v| cross(along, minus(*v, p))).fold(0.0, f64::max);
                    far / length(along)
                };
                pairs(vertices).map(width).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The point of the surface farthest along `direction`.
    pub fn support(&self, direction: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Ellipse { semi_axes: [a, b] } => {
                let scaled = [a * direction[0], b * direction[1]];
                let size = length(scaled);
                if size == 0.0 { [*a, 0.0] } else { [a * scaled[0] / size, b * scaled[1] / size] }
            }
            Self::Polygon { vertices } => {
                let first = vertices[0];
                vertices
                    .iter()
                    .fold(first, |best, v| if dot(*v, direction) > dot(best, direction) { *v } else { best })
            }
        }
    }

    /// How far the surface of a body that is turned about y by `angle` (rad, from z to x) reaches from its
    /// centre along `direction`, a unit vector of the laboratory, m.
    pub fn reach_along(&self, angle: f64, [x, z]: [f64; 2]) -> f64 {
        let (sine, cosine) = angle.sin_cos();
        let own = [cosine * x - sine * z, sine * x + cosine * z];
        dot(self.support(own), own)
    }

    /// Distance of `point` from the surface, negative inside, and the outward unit normal there, m and 1.
    pub fn distance(&self, point: [f64; 2]) -> (f64, [f64; 2]) {
        match self {
            Self::Ellipse { semi_axes } => from_ellipse(*semi_axes, point),
            Self::Polygon { vertices } => from_polygon(vertices, point),
        }
    }
}

/// Edges: their first and last points.
fn pairs(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(p, q)| (*p, *q))
}

/// Area, positive if the vertices turn from x to z, and centre of mass.
fn area_and_centre(vertices: &[[f64; 2]]) -> (f64, [f64; 2]) {
    // About the first vertex, so that a polygon far from the origin loses no digits.
    let origin = vertices[0];
    let (mut area, mut centre) = (0.0, [0.0; 2]);
    for (p, q) in pairs(vertices) {
        let (p, q) = (minus(p, origin), minus(q, origin));
        let part = 0.5 * cross(p, q);
        area += part;
        (0..2).for_each(|a| centre[a] += part * (p[a] + q[a]) / 3.0);
    }
    (area, [origin[0] + centre[0] / area, origin[1] + centre[1] / area])
}

fn from_polygon(vertices: &[[f64; 2]], point: [f64; 2]) -> (f64, [f64; 2]) {
    let mut inside = (f64::NEG_INFINITY, [1.0, 0.0]);
    let mut outside = (f64::INFINITY, [1.0, 0.0]);
    for (p, q) in pairs(vertices) {
        let (along, from) = (minus(q, p), minus(point, p));
        let size = length(along);
        let normal = [along[1] / size, -along[0] / size];
        let above = dot(from, normal);
        if above > inside.0 {
            inside = (above, normal);
        }
        let part = (dot(from, along) / (size * size)).clamp(0.0, 1.0);
        let away = [from[0] - part * along[0], from[1] - part * along[1]];
        let distance = length(away);
        if distance < outside.0 {
            let corner = part <= 0.0 || part >= 1.0;
            let direction = if corner && distance > 0.0 { away.map(|a| a / distance) } else { normal };
            outside = (distance, direction);
        }
    }
    if inside.0 <= 0.0 { inside } else { outside }
}

/// By Newton's method on the parameter of the nearest point, which lies in the point's own quadrant (Eberly
/// 2013, "Distance from a point to an ellipse").
fn from_ellipse(semi_axes: [f64; 2], point: [f64; 2]) -> (f64, [f64; 2]) {
    let sign = point.map(|x| 1f64.copysign(x));
    // Long axis first.
    let turned = semi_axes[0] < semi_axes[1];
    let order = |v: [f64; 2]| if turned { [v[1], v[0]] } else { v };
    let ([a, b], [x, y]) = (order(semi_axes), order(point.map(f64::abs)));
    let within = (x / a).powi(2) + (y / b).powi(2) <= 1.0;
    let near = if a - b <= 1e-12 * a {
        let size = length([x, y]);
        if size == 0.0 { [0.0, b] } else { [a * x / size, a * y / size] }
    } else if y > 1e-14 * b {
        let (z, r) = ([x / a, y / b], (a / b).powi(2));
        let of = |s: f64| (r * z[0] / (s + r)).powi(2) + (z[1] / (s + 1.0)).powi(2) - 1.0;
        // Convex and falling: Newton's steps from the left end never pass the root.
        let slope = |s: f64| -2.0 * ((r * z[0]).powi(2) / (s + r).powi(3) + z[1].powi(2) / (s + 1.0).powi(3));
        let mut s = z[1] - 1.0;
        for _ in 0..100 {
            let step = of(s) / slope(s);
            s -= step;
            if step.abs() <= 1e-15 * r {
                break;
            }
        }
        [r * x / (s + r), y / (s + 1.0)]
    } else {
        let (part, whole) = (a * x, a * a - b * b);
        if part < whole {
            let at = part / whole;
            [a * at, b * (1.0 - at * at).max(0.0).sqrt()]
        } else {
            [a, 0.0]
        }
    };
    let distance = length([x - near[0], y - near[1]]);
    let normal = [near[0] / (a * a), near[1] / (b * b)];
    let size = length(normal);
    let normal = order(normal.map(|n| n / size));
    (if within { -distance } else { distance }, [sign[0] * normal[0], sign[1] * normal[1]])
}
