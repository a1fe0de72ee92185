//! Membranes against closed forms.

mod patch;
