//! A share of the work, for one of several machines.

use crate::Error;
use std::fmt;
use std::str::FromStr;

/// The `index`-th of `count` shares; every share takes each `count`-th item.
///
/// ```
/// use gemtrace::shard::Shard;
/// let shard: Shard = "2/3".parse()?;
/// let items: Vec<usize> = (0..8).filter(|&item| shard.has(item)).collect();
/// assert_eq!((shard.to_string().as_str(), items.as_slice()), ("2/3", &[1, 4, 7][..]));
/// assert!("0/3".parse::<Shard>().unwrap_err().to_string().contains("from 1/3 to 3/3"));
/// # Ok::<(), gemtrace::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Shard {
    /// From 0.
    index: u32,
    count: u32,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Shard = Shard { index: 0, count: 1 };

    /// The share at `index`, from 0, of `count`; `None` unless `index < count`.
    pub fn new(index: u32, count: u32) -> Option<Self> {
        (index < count).then_some(Shard { index, count })
    }

    /// Which, counted from 0; people count from 1.
    pub fn index(self) -> u32 {
        self.index
    }

    /// Of how many.
    pub fn count(self) -> u32 {
        self.count
    }

    /// Whether this is all of the work.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// The share of `count` that an item belongs to, both counted from 0.
    pub fn of(item: usize, count: u32) -> Shard {
        Shard { index: (item % count as usize) as u32, count }
    }

    /// Whether the item, counted from 0, is in this share.
    pub fn has(self, item: usize) -> bool {
        Shard::of(item, self.count) == self
    }

    /// The share that `text` names: `i/n`, or `auto` for that of the scheduler that runs this process, and all of the work
    /// where there is none.
    ///
    /// # Errors
    /// [`Error::Usage`] for any other text; as [`Shard::from_scheduler`].
    pub fn by_name(text: &str) -> Result<Self, Error> {
        match text {
            "auto" => Ok(Shard::from_scheduler(|name| std::env::var(name).ok())?.unwrap_or(Shard::WHOLE)),
            _ => text.parse(),
        }
    }

    /// The share that a scheduler gives to this process, if there is one; `variable` looks up the environment.
    ///
    /// | scheduler | index | count |
    /// |---|---|---|
    /// | Slurm job array | (`SLURM_ARRAY_TASK_ID` − `…_MIN`) / `…_STEP` | `SLURM_ARRAY_TASK_COUNT` |
    /// | Kubernetes Indexed Job | `JOB_COMPLETION_INDEX` | `GEMTRACE_SHARDS`, the Job's `completions` |
    ///
    /// Without `SLURM_ARRAY_TASK_MIN` the index is the task's number modulo the count.
    ///
    /// (Slurm's manual, sbatch, "Output environment variables"; Kubernetes, "Job completion mode". Slurm leaves
    /// `…_STEP` at 1 for lists of task numbers, and Kubernetes does not tell the count at all.)
    ///
    /// # Errors
    /// [`Error::Usage`] where they contradict each other or the count is missing.
    pub fn from_scheduler(variable: impl Fn(&str) -> Option<String>) -> Result<Option<Self>, Error> {
        let number = |name: &str| variable(name).map(|text| parse(name, &text)).transpose();
        if let Some(task) = number("SLURM_ARRAY_TASK_ID")? {
            let count = number("SLURM_ARRAY_TASK_COUNT")?.ok_or_else(|| missing("SLURM_ARRAY_TASK_COUNT"))?;
            let Some(first) = number("SLURM_ARRAY_TASK_MIN")? else {
                // Consecutive numbers, wherever they begin, fall on each share once.
                return Ok(Shard::new(task % count.max(1), count));
            };
            let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
            let index = task.checked_sub(first).filter(|ahead| ahead % step == 0).map(|ahead| ahead / step);
            let shard = index.and_then(|index| Shard::new(index, count));
            let message = || {
                format!(
                    "array task {task} is not one of {count} in even steps of {step} from {first}; \
                     give --shard i/n, or an array such as 1-{count}"
                )
            };
            return shard.map(Some).ok_or_else(|| Error::Usage(message()));
        }
        if let Some(index) = number("JOB_COMPLETION_INDEX")? {
            let count = number("GEMTRACE_SHARDS")?.ok_or_else(|| missing("GEMTRACE_SHARDS"))?;
            let message = || {
                format!(
                    "JOB_COMPLETION_INDEX is {index}, but GEMTRACE_SHARDS says there are {count}, from 0 on"
                )
            };
            return Shard::new(index, count).map(Some).ok_or_else(|| Error::Usage(message()));
        }
        Ok(None)
    }
}

fn parse(name: &str, text: &str) -> Result<u32, Error> {
    let message = || format!("the environment variable {name} is '{text}', where a whole number is expected");
    text.trim().parse().map_err(|_| Error::Usage(message()))
}

fn missing(name: &str) -> Error {
    Error::Usage(format!(
        "a scheduler gives this process a number but not the count: set {name}, or give --shard i/n"
    ))
}

impl fmt::Display for Shard {
    /// As people count: the first of three is 1/3.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let numbers = text
            .split_once('/')
            .and_then(|(i, n)| Some((i.trim().parse::<u32>().ok()?, n.trim().parse::<u32>().ok()?)));
        match numbers {
            Some((i, n)) if (1..=n).contains(&i) => Ok(Shard { index: i - 1, count: n }),
            Some((_, n)) if n > 0 => {
                Err(Error::Usage(format!("'{text}' is not a share: {n} shares are from 1/{n} to {n}/{n}")))
            }
            _ => Err(Error::Usage(format!("'{text}' is not a share; give i/n, such as 1/8 to 8/8"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scheduled(variables: &[(&str, &str)]) -> Result<Option<Shard>, Error> {
        let found = |name: &str| variables.iter().find(|(key, _)| *key == name).map(|(_, v)| (*v).to_owned());
        Shard::from_scheduler(found)
    }

    fn slurm(task: &str, min: &str, step: &str, count: &str) -> Result<Option<Shard>, Error> {
        scheduled(&[
            ("SLURM_ARRAY_TASK_ID", task),
            ("SLURM_ARRAY_TASK_MIN", min),
            ("SLURM_ARRAY_TASK_STEP", step),
            ("SLURM_ARRAY_TASK_COUNT", count),
        ])
    }

    #[test]
    fn every_item_is_in_exactly_one_share() {
        for count in 1..9 {
            let shares: Vec<Shard> = (0..count).filter_map(|i| Shard::new(i, count)).collect();
            for item in 0..40 {
                assert_eq!(shares.iter().filter(|share| share.has(item)).count(), 1);
            }
        }
    }

    #[test]
    fn arrays_and_indexed_jobs_are_understood() {
        assert_eq!(scheduled(&[]), Ok(None));
        assert_eq!(slurm("0", "0", "1", "8"), Ok(Shard::new(0, 8)));
        assert_eq!(slurm("8", "1", "1", "8"), Ok(Shard::new(7, 8)));
        assert_eq!(slurm("10", "4", "3", "3"), Ok(Shard::new(2, 3)));
        for (task, index) in [("0", 0), ("1", 1), ("2", 0)] {
            let two = [("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_COUNT", "2")];
            assert_eq!(scheduled(&two), Ok(Shard::new(index, 2)));
        }
        let job = [("JOB_COMPLETION_INDEX", "3"), ("GEMTRACE_SHARDS", "4")];
        assert_eq!(scheduled(&job), Ok(Shard::new(3, 4)));
    }

    #[test]
    fn contradictions_are_told() {
        for (found, part) in [
            (slurm("9", "1", "1", "8"), "array task 9 is not one of 8"),
            (slurm("5", "3", "4", "2"), "even steps of 4 from 3"),
            (slurm("x", "0", "1", "8"), "SLURM_ARRAY_TASK_ID is 'x'"),
            (scheduled(&[("SLURM_ARRAY_TASK_ID", "1")]), "set SLURM_ARRAY_TASK_COUNT"),
            (scheduled(&[("JOB_COMPLETION_INDEX", "1")]), "set GEMTRACE_SHARDS"),
            (scheduled(&[("JOB_COMPLETION_INDEX", "4"), ("GEMTRACE_SHARDS", "4")]), "from 0 on"),
        ] {
            let message = found.unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        for text in ["", "3", "4/3", "0/3", "1/0", "-1/2", "a/b", "1/2/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
