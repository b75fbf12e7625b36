//! What is changed in a scene, as a change of its TOML document.

use super::overlay::lay;
use super::view::Viewpoint;
use toml::{Table, Value};

/// Keys of which a stone takes exactly one: what it looks like.
pub const FORMS: [&str; 3] = ["cut", "mesh", "shape"];
/// Keys of which an environment takes exactly one: where its light comes from.
const LIGHTS: [&str; 4] = ["image", "uniform", "preset", "model"];

/// One change.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// Keys of the stone; a form takes the place of whatever form it had.
    Stone(Table),
    /// The stone's material, and what `[material.NAME]` says of it if it is none of the catalogue's.
    Material(String, Option<Table>),
    /// The stone's width, mm.
    Width(f64),
    /// Keys of the environment, in its place if they say where the light comes from, else over it.
    Light(Table),
    /// The camera.
    View(Viewpoint),
    /// Any keys.
    Any(Table),
}

impl Change {
    /// Changes a scene; `stone` says which of its stones, all if `None`.
    ///
    /// # Errors
    /// What the scene lacks for it.
    pub fn apply(&self, scene: &mut Table, stone: Option<usize>) -> Result<(), String> {
        match self {
            Change::Stone(keys) => each_stone(scene, stone, |table| {
                if FORMS.iter().any(|form| keys.contains_key(*form)) {
                    FORMS.iter().for_each(|form| drop(table.remove(*form)));
                }
                lay(table, keys);
            }),
            Change::Material(name, definition) => {
                if let Some(definition) = definition {
                    let own = scene.entry("material").or_insert_with(|| Value::Table(Table::new()));
                    let own = own.as_table_mut().ok_or("'material' of the base scene is no table")?;
                    own.insert(name.clone(), Value::Table(definition.clone()));
                }
                each_stone(scene, stone, |table| {
                    table.insert("material".to_owned(), Value::String(name.clone()));
                })
            }
            Change::Width(width) => each_stone(scene, stone, |table| {
                table.insert("width".to_owned(), Value::Float(*width));
            }),
            Change::Light(keys) => {
                if LIGHTS.iter().any(|light| keys.contains_key(*light)) {
                    scene.insert("environment".to_owned(), Value::Table(keys.clone()));
                } else {
                    lay(table(scene, "environment")?, keys);
                }
                Ok(())
            }
            Change::View(view) => view.apply(table(scene, "camera")?),
            Change::Any(keys) => {
                lay(scene, keys);
                Ok(())
            }
        }
    }
}

fn table<'a>(scene: &'a mut Table, key: &str) -> Result<&'a mut Table, String> {
    let value = scene.entry(key).or_insert_with(|| Value::Table(Table::new()));
    value.as_table_mut().ok_or_else(|| format!("'{key}' of the base scene is no table"))
}

/// Does something to the stone, or to each; a scene without a stone gets one.
fn each_stone(
    scene: &mut Table,
    stone: Option<usize>,
    mut change: impl FnMut(&mut Table),
) -> Result<(), String> {
    let stones = scene.entry("stone").or_insert_with(|| Value::Array(vec![Value::Table(Table::new())]));
    let wrong = || "'stone' of the base scene is no list of tables".to_owned();
    let stones = stones.as_array_mut().ok_or_else(wrong)?;
    for (number, value) in stones.iter_mut().enumerate() {
        if stone.is_none_or(|only| only == number) {
            change(value.as_table_mut().ok_or_else(wrong)?);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table_of(text: &str) -> Table {
        toml::from_str(text).unwrap()
    }

    fn changed(scene: &str, change: Change, stone: Option<usize>) -> Table {
        let mut scene = table_of(scene);
        change.apply(&mut scene, stone).unwrap();
        scene
    }

    #[test]
    fn a_form_takes_the_place_of_another() {
        let scene = "stone = [{ mesh = 'a.stl', width = 2, name = 'x' }]";
        let found = changed(scene, Change::Stone(table_of("cut = 'b.asc'")), None);
        assert_eq!(found, table_of("stone = [{ cut = 'b.asc', width = 2, name = 'x' }]"));
        let found = changed("", Change::Stone(table_of("shape = 'step'")), None);
        assert_eq!(found, table_of("stone = [{ shape = 'step' }]"));
    }

    #[test]
    fn one_stone_can_be_meant() {
        let scene = "stone = [{ width = 1 }, { width = 2 }]";
        assert_eq!(
            changed(scene, Change::Width(5.0), Some(1)),
            table_of("stone = [{ width = 1 }, { width = 5.0 }]")
        );
        let material = Change::Material("ink".into(), Some(table_of("like = 'quartz'")));
        assert_eq!(
            changed("stone = [{}, {}]", material, None),
            table_of("stone = [{ material = 'ink' }, { material = 'ink' }]\nmaterial.ink.like = 'quartz'")
        );
    }

    #[test]
    fn a_light_replaces_and_a_rotation_adds() {
        let scene = "environment = { image = 'sky.exr', scale = 2.0 }";
        let found = changed(scene, Change::Light(table_of("uniform = [1, 1, 1]")), None);
        assert_eq!(found, table_of("environment = { uniform = [1, 1, 1] }"));
        let found = changed(scene, Change::Light(table_of("rotation = 30")), None);
        assert_eq!(found, table_of("environment = { image = 'sky.exr', scale = 2.0, rotation = 30 }"));
    }

    #[test]
    fn any_key_can_be_laid_over() {
        let found = changed(
            "render = { samples = 4, max_depth = 9 }",
            Change::Any(table_of("render.samples = 1\nformat = 1")),
            None,
        );
        assert_eq!(found, table_of("render = { samples = 1, max_depth = 9 }\nformat = 1"));
    }
}
