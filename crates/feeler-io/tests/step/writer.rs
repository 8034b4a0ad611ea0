//! Small STEP files as texts.

use feeler_io::Document;

/// Writes the entities of small files.
#[derive(Default)]
pub(crate) struct Writer {
    pub(crate) text: String,
    pub(crate) count: usize,
}

impl Writer {
    pub(crate) fn put(&mut self, entity: impl AsRef<str>) -> String {
        self.count += 1;
        self.text
            .push_str(&format!("#{}={};\n", self.count, entity.as_ref()));
        format!("#{}", self.count)
    }

    pub(crate) fn point(&mut self, [x, y, z]: [f64; 3]) -> String {
        self.put(format!("CARTESIAN_POINT('',({x:?},{y:?},{z:?}))"))
    }

    pub(crate) fn direction(&mut self, [x, y, z]: [f64; 3]) -> String {
        self.put(format!("DIRECTION('',({x:?},{y:?},{z:?}))"))
    }

    pub(crate) fn axes(&mut self, at: [f64; 3], z: [f64; 3], x: [f64; 3]) -> String {
        let (at, z, x) = (self.point(at), self.direction(z), self.direction(x));
        self.put(format!("AXIS2_PLACEMENT_3D('',{at},{z},{x})"))
    }

    pub(crate) fn circle(&mut self, at: [f64; 3], z: [f64; 3], x: [f64; 3], radius: f64) -> String {
        let axes = self.axes(at, z, x);
        self.put(format!("CIRCLE('',{axes},{radius:?})"))
    }

    pub(crate) fn vertex(&mut self, at: [f64; 3]) -> String {
        let p = self.point(at);
        self.put(format!("VERTEX_POINT('',{p})"))
    }

    pub(crate) fn edge(&mut self, from: &str, to: &str, curve: &str) -> String {
        self.put(format!("EDGE_CURVE('',{from},{to},{curve},.T.)"))
    }

    /// A whole circle as an edge from its start to its start.
    pub(crate) fn round(&mut self, at: [f64; 3], z: [f64; 3], x: [f64; 3], radius: f64) -> String {
        let curve = self.circle(at, z, x, radius);
        let start = [0, 1, 2].map(|i| at[i] + radius * x[i]);
        let v = self.vertex(start);
        self.edge(&v, &v, &curve)
    }

    pub(crate) fn bound(&mut self, edges: &[(&str, bool)]) -> String {
        let uses: Vec<String> = { edges.iter() }
            .map(|(e, forward)| {
                let sense = if *forward { "T" } else { "F" };
                self.put(format!("ORIENTED_EDGE('',*,*,{e},.{sense}.)"))
            })
            .collect();
        let l = self.put(format!("EDGE_LOOP('',({}))", uses.join(",")));
        self.put(format!("FACE_BOUND('',{l},.T.)"))
    }

    pub(crate) fn face(&mut self, surface: &str, bounds: &[String]) -> String {
        self.put(format!(
            "ADVANCED_FACE('',({}),{surface},.T.)",
            bounds.join(",")
        ))
    }

    pub(crate) fn sheet(&mut self, faces: &[String]) -> String {
        let shell = self.put(format!("OPEN_SHELL('',({}))", faces.join(",")));
        self.put(format!("SHELL_BASED_SURFACE_MODEL('',({shell}))"))
    }

    /// A whole ball: no loop bounds it.
    pub(crate) fn ball(&mut self, at: [f64; 3], radius: f64) -> String {
        let axes = self.axes(at, [0., 0., 1.], [1., 0., 0.]);
        let s = self.put(format!("SPHERICAL_SURFACE('',{axes},{radius:?})"));
        let pole = self.vertex([at[0], at[1], at[2] - radius]);
        let l = self.put(format!("VERTEX_LOOP('',{pole})"));
        let bound = self.put(format!("FACE_BOUND('',{l},.T.)"));
        let face = self.face(&s, &[bound]);
        let shell = self.put(format!("CLOSED_SHELL('',({face}))"));
        self.put(format!("MANIFOLD_SOLID_BREP('',{shell})"))
    }

    pub(crate) fn millimetres(&mut self) -> String {
        self.put("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    }

    pub(crate) fn inches(&mut self) -> String {
        let mm = self.millimetres();
        let m = self.put(format!(
            "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{mm})"
        ));
        self.put(format!(
            "(CONVERSION_BASED_UNIT('INCH',{m})LENGTH_UNIT()NAMED_UNIT($))"
        ))
    }

    /// With what is said of its uncertainty.
    pub(crate) fn context(&mut self, units: &str, uncertainty: &str) -> String {
        self.put(format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT(({units}))REPRESENTATION_CONTEXT('',''))"
        ))
    }

    pub(crate) fn representation(&mut self, items: &str, context: &str) -> String {
        self.put(format!("SHAPE_REPRESENTATION('',({items}),{context})"))
    }

    pub(crate) fn document(&self) -> Document {
        self.read().unwrap_or_else(|e| panic!("{e}"))
    }

    pub(crate) fn read(&self) -> Result<Document, feeler_io::ReadError> {
        let text = format!(
            "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;\n{}ENDSEC;END-ISO-10303-21;",
            self.text
        );
        feeler_io::read_step(text.as_bytes())
    }
}
