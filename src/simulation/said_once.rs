//! Notices to the user while a run goes on, each given once, also if the run was resumed from a checkpoint.

use super::Column;
use std::collections::BTreeSet;

/// Sentences for the user, each under a key that is spoken of once in a run.
#[derive(Debug, Clone, Default)]
///
/// ```
/// use lateen::simulation::SaidOnce;
///
/// let mut notices = SaidOnce::default();
/// for time in [0.1, 0.2] {
///     notices.say("energy", || format!("energy is lost at t = {time} s"));
/// }
/// assert_eq!(notices.take(), ["energy is lost at t = 0.1 s"]);
/// ```
pub struct SaidOnce {
    said: BTreeSet<String>,
    pending: Vec<String>,
    /// True if the column of a checkpoint was not whole lines of text.
    torn: bool,
}

impl SaidOnce {
    /// Says `text`, unless something was said under this key before.
    pub fn say(&mut self, key: &str, text: impl FnOnce() -> String) {
        // A line each in the checkpoint.
        if self.said.insert(key.replace('\n', " ")) {
            self.pending.push(text());
        }
    }

    /// The notices since the last call.
    pub fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.pending)
    }

    /// Shows the keys to a checkpoint, as the lines of a text. Their notices have been taken by then.
    pub fn column(&mut self, name: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let mut text: Vec<u8> = self.said.iter().flat_map(|key| [key.as_bytes(), b"\n"].concat()).collect();
        let shown = text.clone();
        visit(name, Column::growing(&mut text));
        if text == shown {
            return;
        }
        let read = String::from_utf8_lossy(&text);
        self.torn = !(text.is_empty() || read.ends_with('\n') && std::str::from_utf8(&text).is_ok());
        self.said = read.split_terminator('\n').map(str::to_owned).collect();
    }

    /// An inconsistency of keys that were just restored, as a sentence.
    pub fn misfit(&self) -> Option<String> {
        self.torn.then(|| "what it has told its user is no text".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::SaidOnce;

    fn keys(notices: &mut SaidOnce) -> Vec<u8> {
        let mut bytes = Vec::new();
        notices.column("said", &mut |_, column| bytes = column.data.bytes().to_vec());
        bytes
    }

    fn restored(bytes: &[u8]) -> SaidOnce {
        let mut notices = SaidOnce::default();
        notices.column("said", &mut |_, column| assert!(column.data.replace(bytes)));
        notices
    }

    #[test]
    fn a_key_is_spoken_of_once_also_after_a_restore() {
        let mut first = SaidOnce::default();
        first.say("strain energy: a\nb", || "one".into());
        first.say("strain energy: a\nb", || "again".into());
        first.say("friction", || "two".into());
        assert_eq!(first.take(), ["one", "two"]);
        let mut second = restored(&keys(&mut first));
        assert_eq!(second.misfit(), None);
        for key in ["strain energy: a\nb", "friction", "contact"] {
            second.say(key, || key.to_owned());
        }
        assert_eq!(second.take(), ["contact"]);
        assert!(first.take().is_empty());
    }

    #[test]
    fn keys_that_are_cut_off_or_not_utf8_are_refused() {
        assert!(restored(b"").misfit().is_none() && restored(b"one\n").misfit().is_none());
        for torn in [&b"one\ntw"[..], b"\xff\xff\n", b"one"] {
            assert!(restored(torn).misfit().is_some(), "{torn:?}");
        }
    }
}
