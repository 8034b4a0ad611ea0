//! The triangles of one face.
//!
//! All is done in the coordinates of the grid: cell (i, j) is the unit square at (i, j), and lines between are
//! spread linearly. There triangles are well shaped where cells are.

use super::edges::TrimPoints;
use super::{Mesh, Rule, Stopped, steps};
use feeler::brep::Brep;
use feeler::nurbs::Surface;
use nalgebra::{Matrix2, Point2, Point3, Vector2};
use spade::{ConstrainedDelaunayTriangulation, Point2 as Site, Triangulation};
use std::collections::{BTreeMap, HashMap};

/// Triangles a face whose distance to the surface is sampled, at the centre and the middles of the sides.
pub(super) const SAMPLED: usize = 2_000;
/// A grid point nearer to a trim than this, in cells, is left out: its triangles would be slivers.
const CLEAR: f64 = 0.4;
/// Below this a coordinate is 0 to the triangulation (its predicates would underflow); in cells.
const TINY: f64 = 1e-30;
/// Joints of a loop nearer than this, in cells, are one point.
const JOINT: f64 = 1e-9;

/// A point of a face: in cells, and which corner of the mesh.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: [f64; 2],
    vertex: u32,
}

type Cdt = ConstrainedDelaunayTriangulation<Site<f64>>;

struct Grid<'a> {
    surface: &'a Surface,
    cuts: [Vec<f64>; 2],
}

impl Grid<'_> {
    fn cells(&self, axis: usize) -> usize {
        self.cuts[axis].len() - 1
    }

    /// A parameter in cells, clamped to the domain.
    fn to_cells(&self, uv: Point2<f64>) -> [f64; 2] {
        [0, 1].map(|axis| {
            let cuts = &self.cuts[axis];
            let x = uv[axis].clamp(cuts[0], cuts[cuts.len() - 1]);
            let i = cuts.partition_point(|c| *c <= x).clamp(1, cuts.len() - 1);
            let s = (x - cuts[i - 1]) / (cuts[i] - cuts[i - 1]);
            let at = (i - 1) as f64 + s;
            if at.abs() < TINY { 0.0 } else { at }
        })
    }

    fn to_uv(&self, at: [f64; 2]) -> Point2<f64> {
        let uv = [0, 1].map(|axis| {
            let cuts = &self.cuts[axis];
            let i = (at[axis].max(0.0) as usize).min(cuts.len() - 2);
            cuts[i] + (at[axis] - i as f64) * (cuts[i + 1] - cuts[i])
        });
        uv.into()
    }

    fn point(&self, at: [f64; 2]) -> Point3<f64> {
        let uv = self.to_uv(at);
        self.surface.point(uv.x, uv.y)
    }
}

/// What is known of the grid's points and cells.
struct Marks {
    size: [usize; 2],
    /// Points inside and clear of all trims.
    free: Vec<bool>,
    /// Cells that no trim touches and whose four points are free.
    full: Vec<bool>,
}

impl Marks {
    fn point(&self, i: usize, j: usize) -> usize {
        j * (self.size[0] + 1) + i
    }

    fn is_full(&self, i: isize, j: isize) -> bool {
        let inside = |k: isize, n: usize| k >= 0 && (k as usize) < n;
        inside(i, self.size[0])
            && inside(j, self.size[1])
            && self.full[j as usize * self.size[0] + i as usize]
    }

    fn new(size: [usize; 2], loops: &[Vec<Corner>]) -> Self {
        let [nu, nv] = size;
        let mut marks = Self {
            size,
            free: vec![false; (nu + 1) * (nv + 1)],
            full: vec![true; nu * nv],
        };
        // Inside by parity, row by row; a segment counts in [lower, upper).
        let mut rows: Vec<Vec<f64>> = vec![Vec::new(); nv + 1];
        for [a, b] in sides(loops) {
            let (lo, hi) = if a[1] < b[1] { (a, b) } else { (b, a) };
            let first = lo[1].ceil().max(0.0) as usize;
            for (j, row) in rows.iter_mut().enumerate().skip(first) {
                if j as f64 >= hi[1] {
                    break;
                }
                row.push(lo[0] + (hi[0] - lo[0]) * (j as f64 - lo[1]) / (hi[1] - lo[1]));
            }
        }
        for (j, row) in rows.iter_mut().enumerate() {
            row.sort_by(f64::total_cmp);
            for i in 0..=nu {
                let at = marks.point(i, j);
                marks.free[at] = row.partition_point(|x| *x <= i as f64) % 2 == 1;
            }
        }
        // What is near a trim is not free, and what a trim may touch is not full.
        let range = |lo: f64, hi: f64, n: usize| {
            let first = lo.ceil().max(0.0) as usize;
            let last = ((hi.floor() + 1.0).max(0.0) as usize).min(n);
            first..last
        };
        for [a, b] in sides(loops) {
            let lo = [0, 1].map(|k| a[k].min(b[k]));
            let hi = [0, 1].map(|k| a[k].max(b[k]));
            for j in range(lo[1] - CLEAR, hi[1] + CLEAR, nv + 1) {
                for i in range(lo[0] - CLEAR, hi[0] + CLEAR, nu + 1) {
                    if distance([i as f64, j as f64], a, b) < CLEAR {
                        let at = marks.point(i, j);
                        marks.free[at] = false;
                    }
                }
            }
            // Also cells that it touches from outside.
            for j in range(lo[1] - 1.0, hi[1], nv) {
                for i in range(lo[0] - 1.0, hi[0], nu) {
                    marks.full[j * nu + i] = false;
                }
            }
        }
        for j in 0..nv {
            for i in 0..nu {
                let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
                let free = corners.iter().all(|c| marks.free[marks.point(c.0, c.1)]);
                marks.full[j * nu + i] &= free;
            }
        }
        marks
    }
}

fn sides(loops: &[Vec<Corner>]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    loops.iter().flat_map(|l| {
        let next = |i: usize| l[(i + 1) % l.len()].at;
        l.iter().enumerate().map(move |(i, c)| [c.at, next(i)])
    })
}

/// Distance of a point from a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [p, a, b] = [p, a, b].map(Point2::from);
    let way = b - a;
    let s = (p - a).dot(&way) / way.norm_squared();
    let s = if s.is_finite() {
        s.clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + way * s - p).norm()
}

/// Parity of a point against polygons.
fn inside(p: [f64; 2], loops: &[Vec<Corner>]) -> bool {
    let crosses = |[a, b]: &[[f64; 2]; 2]| {
        (a[1] <= p[1]) != (b[1] <= p[1])
            && a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) > p[0]
    };
    sides(loops).filter(crosses).count() % 2 == 1
}

fn center(t: &[Corner; 3]) -> [f64; 2] {
    [0, 1].map(|k| (t[0].at[k] + t[1].at[k] + t[2].at[k]) / 3.0)
}

/// Which triangles are inside, by the number of sides crossed from outside.
fn by_edges(cdt: &Cdt, sides: &HashMap<usize, u32>) -> Vec<bool> {
    let mut parity: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face();
    parity[outer.index()] = Some(false);
    let mut stack: Vec<_> = cdt
        .convex_hull()
        .filter_map(|e| Some((e, e.rev().face().as_inner()?)))
        .collect();
    while let Some((edge, face)) = stack.pop() {
        if parity[face.index()].is_some() {
            continue;
        }
        let crossed = sides.get(&edge.as_undirected().fix().index()).unwrap_or(&0);
        let before = parity[edge.face().index()].unwrap_or(false);
        parity[face.index()] = Some(before ^ (crossed % 2 == 1));
        for e in face.adjacent_edges() {
            if let Some(next) = e.rev().face().as_inner()
                && parity[next.index()].is_none()
            {
                stack.push((e, next));
            }
        }
    }
    parity.into_iter().map(|p| p == Some(true)).collect()
}

/// The same by one point of each part that lines enclose.
fn by_points(cdt: &Cdt, corners: &[Corner], loops: &[Vec<Corner>]) -> Vec<bool> {
    let mut kept = vec![false; cdt.num_all_faces()];
    let mut seen = kept.clone();
    for start in cdt.inner_faces() {
        if std::mem::replace(&mut seen[start.index()], true) {
            continue;
        }
        let (mut stack, mut part) = (vec![start], Vec::new());
        let mut largest = (f64::NEG_INFINITY, [0.0; 2]);
        while let Some(one) = stack.pop() {
            part.push(one.index());
            let triangle = one.vertices().map(|v| corners[v.index()]);
            let [a, b, c] = triangle.map(|c| Point2::from(c.at));
            let area = (b - a).perp(&(c - a));
            if area > largest.0 {
                largest = (area, center(&triangle));
            }
            for edge in one.adjacent_edges() {
                if let (false, Some(next)) =
                    (edge.is_constraint_edge(), edge.rev().face().as_inner())
                    && !std::mem::replace(&mut seen[next.index()], true)
                {
                    stack.push(next);
                }
            }
        }
        if inside(largest.1, loops) {
            part.into_iter().for_each(|i| kept[i] = true);
        }
    }
    kept
}

/// Adds the triangles of a face to the mesh. Whether polygons that stand for its loops cross.
pub(super) fn triangulate(
    brep: &Brep,
    face: usize,
    rule: &Rule,
    trims: &[TrimPoints],
    most: usize,
    mesh: &mut Mesh,
) -> Result<bool, Stopped> {
    let surface = brep.surface(face);
    let grid = Grid {
        surface,
        cuts: steps::grid(surface, rule),
    };
    let size = [grid.cells(0), grid.cells(1)];
    let cells = 2usize.saturating_mul(size[0]).saturating_mul(size[1]);
    if mesh.triangles.len().saturating_add(cells) > most {
        return Err(Stopped::TooMany);
    }
    let loops = polygons(brep, face, &grid, trims, mesh);
    let marks = Marks::new(size, &loops);
    let mut work = Work {
        face,
        flip: brep.faces()[face].reversed,
        grid: &grid,
        ids: vec![u32::MAX; marks.free.len()],
        sampled: Vec::new(),
        // Evenly, whatever their number will be: about two a cell.
        every: (2 * size[0] * size[1]).div_ceil(SAMPLED).max(1),
        count: 0,
        mesh,
    };
    work.cells(&marks);
    let crossed = work.strip(&marks, &loops).map_err(Stopped::Face)?;
    let found = work.chord_error();
    mesh.chord_error = mesh.chord_error.max(found);
    Ok(crossed)
}

/// The loops as polygons, in cells.
fn polygons(
    brep: &Brep,
    face: usize,
    grid: &Grid<'_>,
    trims: &[TrimPoints],
    mesh: &mut Mesh,
) -> Vec<Vec<Corner>> {
    let parts = brep.parts();
    let Some(loops) = &brep.faces()[face].loops else {
        // The whole domain.
        let [nu, nv] = [grid.cells(0), grid.cells(1)];
        let south = (0..nu).map(|i| [i, 0]);
        let east = (0..nv).map(|j| [nu, j]);
        let north = (1..=nu).rev().map(|i| [i, nv]);
        let west = (1..=nv).rev().map(|j| [0, j]);
        let around = south.chain(east).chain(north).chain(west);
        let corner = |ij: [usize; 2]| {
            let at = ij.map(|k| k as f64);
            let vertex = mesh.vertex(grid.point(at).coords.into());
            Corner { at, vertex }
        };
        return vec![around.map(corner).collect()];
    };
    let near = |a: &Corner, b: &Corner| {
        (Point2::from(a.at) - Point2::from(b.at)).norm() < JOINT && a.vertex == b.vertex
    };
    let mut all = Vec::new();
    for &l in loops {
        let mut polygon: Vec<Corner> = Vec::new();
        for &trim in &parts.loops[l].trims {
            let points = &trims[trim];
            for (uv, vertex) in points.uv.iter().zip(&points.vertices) {
                let corner = Corner {
                    at: grid.to_cells(*uv),
                    vertex: *vertex,
                };
                if !polygon.last().is_some_and(|last| near(last, &corner)) {
                    polygon.push(corner);
                }
            }
        }
        while polygon.len() > 1 && near(&polygon[0], &polygon[polygon.len() - 1]) {
            polygon.pop();
        }
        let polygon = with_poles(&polygon);
        if polygon.len() > 2 {
            all.push(polygon);
        }
    }
    all
}

/// A side whose ends are one corner of the mesh runs along a pole: it gets a point on each grid line, so that
/// triangles there keep to their column.
fn with_poles(polygon: &[Corner]) -> Vec<Corner> {
    let mut all = Vec::with_capacity(polygon.len());
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        all.push(*a);
        if a.vertex != b.vertex {
            continue;
        }
        let way = [0, 1].map(|k| b.at[k] - a.at[k]);
        let axis = usize::from(way[1].abs() > way[0].abs());
        let (lo, hi) = (a.at[axis].min(b.at[axis]), a.at[axis].max(b.at[axis]));
        let lines = (lo.floor() as usize + 1)..(hi.ceil() as usize);
        let mut between: Vec<Corner> = lines
            .map(|line| {
                let s = (line as f64 - a.at[axis]) / way[axis];
                let mut at = [0, 1].map(|k| a.at[k] + s * way[k]);
                at[axis] = line as f64;
                Corner { at, ..*a }
            })
            .collect();
        if way[axis] < 0.0 {
            between.reverse();
        }
        all.extend(between);
    }
    all
}

struct Work<'a> {
    face: usize,
    flip: bool,
    grid: &'a Grid<'a>,
    /// Corners of the mesh at grid points.
    ids: Vec<u32>,
    sampled: Vec<[Corner; 3]>,
    every: usize,
    count: usize,
    mesh: &'a mut Mesh,
}

impl Work<'_> {
    fn grid_corner(&mut self, marks: &Marks, i: usize, j: usize) -> Corner {
        let at = [i as f64, j as f64];
        let index = marks.point(i, j);
        if self.ids[index] == u32::MAX {
            self.ids[index] = self.mesh.vertex(self.grid.point(at).coords.into());
        }
        Corner {
            at,
            vertex: self.ids[index],
        }
    }

    /// A triangle that is counter-clockwise in uv.
    fn triangle(&mut self, corners: [Corner; 3]) {
        if self.count.is_multiple_of(self.every) {
            self.sampled.push(corners);
        }
        self.count += 1;
        let [a, b, c] = corners;
        let turned = if self.flip { [a, c, b] } else { [a, b, c] };
        let grid = self.grid;
        self.mesh.triangle(turned.map(|c| c.vertex), self.face, || {
            turned.map(|c| grid.to_uv(c.at))
        });
    }

    /// Two triangles for each full cell, along its shorter diagonal.
    fn cells(&mut self, marks: &Marks) {
        let [nu, nv] = marks.size;
        for j in 0..nv {
            for i in 0..nu {
                if !marks.full[j * nu + i] {
                    continue;
                }
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    .map(|(i, j)| self.grid_corner(marks, i, j));
                let length = |p: &Corner, q: &Corner| {
                    let at = |c: &Corner| Point3::from(self.mesh.vertices[c.vertex as usize]);
                    (at(p) - at(q)).norm()
                };
                if length(&a, &c) <= length(&b, &d) {
                    self.triangle([a, b, c]);
                    self.triangle([a, c, d]);
                } else {
                    self.triangle([a, b, d]);
                    self.triangle([b, c, d]);
                }
            }
        }
    }

    /// The triangles between full cells and trims. Whether polygons cross.
    fn strip(&mut self, marks: &Marks, loops: &[Vec<Corner>]) -> Result<bool, String> {
        let mut cdt = Cdt::new();
        // By the number of the site.
        let mut corners: Vec<Corner> = Vec::new();
        let mut insert = |cdt: &mut Cdt, c: Corner| {
            let site = Site::new(c.at[0], c.at[1]);
            let handle = cdt.insert(site).map_err(|e| e.to_string())?;
            if handle.index() == corners.len() {
                corners.push(c);
            }
            Ok::<_, String>(handle)
        };
        let mut lines = Vec::new();
        for polygon in loops {
            let mut handles = Vec::with_capacity(polygon.len());
            for corner in polygon {
                handles.push(insert(&mut cdt, *corner)?);
            }
            let next = |i: usize| handles[(i + 1) % handles.len()];
            lines.extend(handles.iter().enumerate().map(|(i, h)| (*h, next(i))));
        }
        let [nu, nv] = marks.size;
        let mut sites = BTreeMap::new();
        for j in 0..=nv {
            for i in 0..=nu {
                let (x, y) = (i as isize, j as isize);
                let around = [(x - 1, y - 1), (x, y - 1), (x - 1, y), (x, y)];
                let enclosed = around.iter().all(|c| marks.is_full(c.0, c.1));
                if marks.free[marks.point(i, j)] && !enclosed {
                    let corner = self.grid_corner(marks, i, j);
                    sites.insert((i, j), insert(&mut cdt, corner)?);
                }
            }
        }
        // Between a full cell and another.
        let before = lines.len();
        for (&(i, j), &from) in &sites {
            let (x, y) = (i as isize, j as isize);
            if marks.is_full(x, y) != marks.is_full(x, y - 1)
                && let Some(to) = sites.get(&(i + 1, j))
            {
                lines.push((from, *to));
            }
            if marks.is_full(x, y) != marks.is_full(x - 1, y)
                && let Some(to) = sites.get(&(i, j + 1))
            {
                lines.push((from, *to));
            }
        }
        let borders = lines.len() - before;
        // How many sides of polygons run along each edge.
        let mut sides: HashMap<usize, u32> = HashMap::new();
        let own = lines.len() - borders;
        for (k, (from, to)) in lines.into_iter().enumerate() {
            if from != to {
                for edge in cdt.add_constraint_and_split(from, to, |site| site) {
                    *sides.entry(edge.as_undirected().index()).or_default() += u32::from(k < own);
                }
            }
        }
        // Where polygons cross there are new sites, and edges counted above may have been split.
        let crossed = cdt.num_vertices() > corners.len();
        for site in cdt.vertices().skip(corners.len()) {
            let at = [site.position().x, site.position().y];
            let vertex = self.mesh.vertex(self.grid.point(at).coords.into());
            corners.push(Corner { at, vertex });
        }
        let kept = if crossed {
            by_points(&cdt, &corners, loops)
        } else {
            by_edges(&cdt, &sides)
        };
        for one in cdt.inner_faces().filter(|f| kept[f.index()]) {
            let triangle = one.vertices().map(|v| corners[v.index()]);
            let middle = center(&triangle).map(|x| x.floor() as isize);
            if !marks.is_full(middle[0], middle[1]) {
                self.triangle(triangle);
            }
        }
        Ok(crossed)
    }

    /// The largest distance found from the sampled triangles to the surface.
    fn chord_error(&self) -> f64 {
        let mut most = 0.0f64;
        for triangle in &self.sampled {
            let corners = triangle.map(|c| Point3::from(self.mesh.vertices[c.vertex as usize]));
            let uv = triangle.map(|c| self.grid.to_uv(c.at));
            for weights in [[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0; 3]] {
                let sum: f64 = weights.iter().sum();
                let (mut p, mut at) = (Point3::origin(), Point2::origin());
                for k in 0..3 {
                    p += corners[k].coords * (weights[k] / sum);
                    at += uv[k].coords * (weights[k] / sum);
                }
                most = most.max(to_surface(self.grid.surface, &p, at));
            }
        }
        most
    }
}

/// Distance of a point from a surface near some parameters, by a few Gauss-Newton steps; at most that to the
/// surface's point there.
fn to_surface(surface: &Surface, p: &Point3<f64>, mut uv: Point2<f64>) -> f64 {
    const STEPS: usize = 6;
    let [u, v] = surface.domain();
    let mut least = f64::INFINITY;
    for _ in 0..STEPS {
        let d = surface.derivatives(uv.x, uv.y, 1);
        let (du, dv) = (d.get(1, 0), d.get(0, 1));
        let r = p.coords - d.get(0, 0);
        if !(r.norm() < least) {
            break;
        }
        least = r.norm();
        let metric = Matrix2::new(du.dot(&du), du.dot(&dv), du.dot(&dv), dv.dot(&dv));
        let Some(inverse) = metric.try_inverse() else {
            break;
        };
        let step = inverse * Vector2::new(du.dot(&r), dv.dot(&r));
        uv.x = (uv.x + step.x).clamp(u.start, u.end);
        uv.y = (uv.y + step.y).clamp(v.start, v.end);
    }
    least
}
