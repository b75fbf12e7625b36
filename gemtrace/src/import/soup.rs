//! Loose triangles, as mesh files hold them, with what they are called.

#[cfg(feature = "formats")]
use super::look::Object;
use glam::DVec3;
use spectral_core::shown;

/// Triangles whose corners are numbers of positions.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Where triangles of another name begin, and that name's number; triangles before the first have none.
    parts: Vec<(usize, usize)>,
    names: Vec<Names>,
}

/// What a file calls some of its triangles: `o`, `g` and `usemtl` of OBJ; nodes, mesh and material of glTF.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Names {
    /// The object's own name, then those of what it belongs to.
    pub objects: Vec<String>,
    pub groups: Vec<String>,
    pub material: Option<String>,
}

impl Names {
    /// All names of a kind, the first kind first.
    fn of(&self, kind: usize) -> &[String] {
        [&self.objects, &self.groups, self.material.as_slice()][kind]
    }

    /// What it is best called.
    fn short(&self) -> Option<&String> {
        self.objects.first().or(self.groups.first())
    }
}

/// Names that a message lists.
const LISTED: usize = 12;

impl Soup {
    /// The triangles to come are called so.
    pub fn begin(&mut self, names: Names) {
        let number = self.number(names);
        self.resume(number);
    }

    /// The number of a name.
    pub fn number(&mut self, names: Names) -> usize {
        // Files that change between names do so in long runs, and the latest come again.
        match self.names.iter().rposition(|known| *known == names) {
            Some(number) => number,
            None => {
                self.names.push(names);
                self.names.len() - 1
            }
        }
    }

    /// The triangles to come have the name of this number.
    pub fn resume(&mut self, number: usize) {
        if self.parts.last().is_none_or(|(_, latest)| *latest != number) {
            self.parts.push((self.triangles.len(), number));
        }
    }

    /// Every name, in the order of the file, with how many triangles have it.
    pub fn parts(&self) -> Vec<(&Names, usize)> {
        let ends = self.parts.iter().skip(1).map(|part| part.0).chain([self.triangles.len()]);
        let mut counts = vec![0; self.names.len()];
        self.parts.iter().zip(ends).for_each(|((start, number), end)| counts[*number] += end - start);
        self.names.iter().zip(counts).filter(|(_, count)| *count > 0).collect()
    }

    /// Keeps the triangles of an object; if none is called so, those of a group, or of a material.
    pub fn select(&mut self, object: &str) -> Result<(), String> {
        let called =
            |kind: usize| self.names.iter().any(|names| names.of(kind).iter().any(|name| name == object));
        let Some(kind) = (0..3).find(|kind| called(*kind)) else {
            let mut valid: Vec<&str> = Vec::new();
            for (names, _) in self.parts() {
                let all = (0..3).flat_map(|kind| names.of(kind));
                all.for_each(|name| {
                    if !valid.contains(&name.as_str()) {
                        valid.push(name);
                    }
                });
            }
            if valid.is_empty() {
                return Err(format!("it has no object '{}': it names none", shown(object)));
            }
            valid.truncate(LISTED);
            return Err(spectral_core::Error::unknown("object", object, valid).to_string());
        };
        let mut kept = Vec::new();
        for (k, (start, number)) in self.parts.iter().enumerate() {
            let end = self.parts.get(k + 1).map_or(self.triangles.len(), |next| next.0);
            if self.names[*number].of(kind).iter().any(|name| name == object) {
                kept.extend_from_slice(&self.triangles[*start..end]);
            }
        }
        self.triangles = kept;
        self.parts.clear();
        Ok(())
    }

    /// Every object; where one is of several materials, the triangles of each material in place of objects.
    #[cfg(feature = "formats")]
    pub fn objects(&self) -> Vec<Object> {
        let mut found: Vec<Object> = Vec::new();
        let mut mixed = false;
        for by_material in [false, true] {
            found.clear();
            for (k, (start, number)) in self.parts.iter().enumerate() {
                let end = self.parts.get(k + 1).map_or(self.triangles.len(), |next| next.0);
                let names = &self.names[*number];
                let name = if by_material {
                    names.material.as_ref()
                } else {
                    names.short().or(names.material.as_ref())
                };
                let corners = self.triangles[*start..end].as_flattened();
                let points = || corners.iter().map(|v| self.positions[*v as usize]);
                let (Some(low), Some(high)) = (points().reduce(DVec3::min), points().reduce(DVec3::max))
                else {
                    continue;
                };
                match found.iter_mut().find(|object| object.name.as_ref() == name) {
                    Some(object) => {
                        mixed |= object.material != names.material;
                        object.triangles += end - start;
                        (object.low, object.high) = (object.low.min(low), object.high.max(high));
                    }
                    None => {
                        let (name, material) = (name.cloned(), names.material.clone());
                        found.push(Object { name, material, triangles: end - start, low, high });
                    }
                }
            }
            if !mixed {
                break;
            }
        }
        if found.is_empty() {
            let points = || self.positions.iter().copied();
            let (low, high) = (points().reduce(DVec3::min), points().reduce(DVec3::max));
            let (low, high) = (low.unwrap_or_default(), high.unwrap_or_default());
            found.push(Object { name: None, material: None, triangles: self.triangles.len(), low, high });
        }
        found
    }

    /// What one should know who takes all of it for one stone.
    pub fn remark(&self) -> Option<String> {
        let list = |of: &dyn Fn(&Names) -> Option<&String>| {
            let mut names: Vec<String> = Vec::new();
            for (part, _) in self.parts() {
                let name = of(part).map(|name| shown(name));
                names.extend(name.filter(|name| !names.contains(name)));
            }
            let more = if names.len() > LISTED { " and more" } else { "" };
            (names.len(), names[..names.len().min(LISTED)].join(", ") + more)
        };
        let ((objects, named), (materials, made)) =
            (list(&Names::short), list(&|names| names.material.as_ref()));
        if objects < 2 && materials < 2 {
            return None;
        }
        let s = |count: usize| if count == 1 { "" } else { "s" };
        let named = if objects > 0 { format!(": {named}") } else { String::new() };
        let made = if materials > 0 {
            format!(" of {materials} material{}: {made}", s(materials))
        } else {
            String::new()
        };
        Some(format!(
            "it holds {objects} object{}{named}{}{made}; together they are one stone: choose with object = \"…\"",
            s(objects),
            if made.is_empty() { "" } else { "," }
        ))
    }
}
