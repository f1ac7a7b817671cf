//! The results folder: arrays, tables and plots, complete under its final name or not there at all.
