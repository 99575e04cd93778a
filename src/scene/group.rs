//! Groups of atoms (LAMMPS doc page `group`): membership is one bit of [`State::mask`] a group.

use super::region::Regions;
use crate::script::command::group::{GroupAction, GroupCommand};
use crate::script::{Complaint, Name};
use crate::system::{GROUP_ALL, State};

/// Groups there can be, as many as a mask has bits.
pub const MAX_GROUPS: usize = 32;

/// The names of the groups; entry k is bit k of the mask, entry 0 is `all`.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    names: Vec<Option<String>>,
}

impl Default for Groups {
    fn default() -> Self {
        Self { names: vec![Some("all".into())] }
    }
}

impl Groups {
    /// The bit of a group by its ID.
    pub fn get(&self, id: &str) -> Option<u32> {
        self.names.iter().position(|name| name.as_deref() == Some(id)).map(|k| 1 << k)
    }

    /// The bit of a group that a command names.
    pub fn find(&self, name: &Name) -> Result<u32, Complaint> {
        self.get(&name.text).ok_or_else(|| {
            let known: Vec<&str> = self.names.iter().flatten().map(String::as_str).collect();
            let message = format!("expected a group ID, got '{}' (defined: {})", name.text, known.join(", "));
            Complaint::new(name.word, message)
        })
    }

    /// The bit of a group, which is made if it is new.
    pub fn find_or_add(&mut self, name: &Name) -> Result<u32, Complaint> {
        if let Some(bit) = self.get(&name.text) {
            return Ok(bit);
        }
        let slot = self.names.iter().position(Option::is_none).unwrap_or(self.names.len());
        if slot >= MAX_GROUPS {
            return Err(Complaint::new(
                name.word,
                format!("there are {MAX_GROUPS} groups already, and no more can be"),
            ));
        }
        if slot == self.names.len() {
            self.names.push(None);
        }
        self.names[slot] = Some(name.text.clone());
        Ok(1 << slot)
    }

    /// Carries out a `group` command; returns how many atoms the group has then (0 for a deleted one).
    /// Errors: undefined groups or regions, too many groups, taking atoms from `all`.
    pub fn apply(&mut self, command: &GroupCommand, state: &mut State, regions: &Regions) -> Result<usize, Complaint> {
        let name = &command.name;
        if matches!(command.action, GroupAction::Clear | GroupAction::Delete) {
            let bit = self.find(name)?;
            if bit == GROUP_ALL {
                return Err(Complaint::new(name.word, "group all cannot be cleared or deleted"));
            }
            state.mask.iter_mut().for_each(|mask| *mask &= !bit);
            if command.action == GroupAction::Delete {
                self.names[bit.trailing_zeros() as usize] = None;
            }
            return Ok(0);
        }
        // What the command names is looked up before the group comes into being.
        let choice = self.choose(&command.action, regions)?;
        let bit = self.find_or_add(name)?;
        add_members(bit, &choice, state);
        Ok(state.mask.iter().filter(|mask| **mask & bit != 0).count())
    }

    fn choose<'a>(&self, action: &'a GroupAction, regions: &'a Regions) -> Result<Choice<'a>, Complaint> {
        let bits = |names: &[Name]| names.iter().map(|n| self.find(n)).collect::<Result<Vec<u32>, _>>();
        Ok(match action {
            GroupAction::Type(numbers) => Choice::Type(numbers),
            GroupAction::Id(numbers) => Choice::Id(numbers),
            GroupAction::Region(name) => Choice::Region(regions.find(name)?),
            GroupAction::Union(names) => Choice::Union(bits(names)?.into_iter().fold(0, |all, b| all | b)),
            GroupAction::Intersect(names) => Choice::Intersect(bits(names)?.into_iter().fold(0, |all, b| all | b)),
            GroupAction::Subtract(names) => {
                let bits = bits(names)?;
                let (first, rest) = bits.split_first().map_or((0, &[][..]), |(f, r)| (*f, r));
                Choice::Subtract { first, rest: rest.iter().fold(0, |all, b| all | b) }
            }
            GroupAction::Empty | GroupAction::Clear | GroupAction::Delete => Choice::Nothing,
        })
    }
}

/// Which atoms join a group, all names looked up.
enum Choice<'a> {
    Type(&'a crate::script::command::group::Numbers),
    Id(&'a crate::script::command::group::Numbers),
    Region(&'a super::region::Region),
    Union(u32),
    Intersect(u32),
    Subtract { first: u32, rest: u32 },
    Nothing,
}

fn add_members(bit: u32, choice: &Choice<'_>, state: &mut State) {
    for k in 0..state.len() {
        let mask = state.mask[k];
        let joins = match choice {
            Choice::Type(numbers) => numbers.contains(i64::from(state.kind[k])),
            Choice::Id(numbers) => numbers.contains(i64::from(state.id[k])),
            Choice::Region(region) => region.contains(&state.x[k]),
            Choice::Union(bits) => mask & bits != 0,
            Choice::Intersect(bits) => mask & bits == *bits,
            Choice::Subtract { first, .. } => mask & first != 0,
            Choice::Nothing => false,
        };
        if joins {
            state.mask[k] |= bit;
        }
        // Subtraction takes atoms away even if they were members before.
        if let Choice::Subtract { rest, .. } = choice
            && state.mask[k] & rest != 0
        {
            state.mask[k] &= !bit;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::test_support::Scene;

    /// 64 atoms on a simple cubic lattice, every fourth of type 2.
    fn scene() -> Scene {
        let mut scene = Scene::new("lattice sc 1\nregion b block 0 4 0 4 0 4\ncreate_box 2 b\ncreate_atoms 1 box");
        scene.state.kind.iter_mut().step_by(4).for_each(|kind| *kind = 2);
        scene
    }

    #[test]
    fn groups_hold_the_atoms_lammps_puts_there() {
        let groups = [
            ("type 2", 16),
            ("type 5", 0),
            ("type 1:2", 64),
            ("type != 2", 48),
            ("id 3:7:2 60", 4),
            ("id <> 3 7", 5),
            ("id >= 60", 5),
            ("id 7:3", 0),
            ("union all", 64),
            ("empty", 0),
        ];
        for (group, count) in groups {
            let mut scene = scene();
            scene.run(&format!("group g {group}")).unwrap();
            assert_eq!(scene.count("g"), count, "{group}");
        }
    }

    #[test]
    fn groups_grow_and_are_subtracted_from() {
        let mut scene = scene();
        for line in ["group a id 1 2 3", "group c id 2 5", "group a intersect a c"] {
            scene.run(line).unwrap();
        }
        // LAMMPS adds the intersection to what was there, and subtracts from members of old.
        assert_eq!(scene.count("a"), 3);
        scene.run("group a subtract a c").unwrap();
        assert_eq!(scene.count("a"), 2);
        scene.run("group a clear").unwrap();
        assert_eq!(scene.count("a"), 0);
        scene.run("group c delete").unwrap();
        assert_eq!(scene.complaint("group a union c"), (3, "expected a group ID, got 'c' (defined: all, a)".into()));
    }

    #[test]
    fn there_are_32_groups_at_most() {
        let mut scene = scene();
        for k in 1..32 {
            scene.run(&format!("group g{k} id {k}")).unwrap();
        }
        assert!(scene.complaint("group g32 id 1").1.contains("32 groups"));
        assert_eq!(scene.complaint("group all clear").0, 1);
        assert_eq!(scene.complaint("group g1 id 1:9:0").0, 3);
        assert_eq!(scene.complaint("group g1 id < 3 4").0, 5);
        assert!(scene.complaint("group g1 dynamic all").1.contains("not part of octant"));
    }
}
