//! Searches that are compiled with this crate, for `f64` in the plane and in space.
//!
//! A generic function is compiled in each crate that calls it, with the options of that crate. Almost all
//! elements are in `f64` and in two or three dimensions, so their searches are compiled here, once and
//! optimised. Where the types are these, the compiler leaves out the generic code.

use std::any::Any;

/// Defines a function that searches with a method of an engine: its code for `f64` in the plane and in space
/// is that of this crate, and other code is compiled where it is called.
macro_rules! compiled {
    (fn $name:ident = $engine:ty, $plane:ty, $space:ty: $method:ident($sink:ty)) => {
        fn $name<T: Real, const D: usize>(
            engine: &mut $engine,
            elements: &Elements<'_, T, D>,
            sink: $sink,
        ) -> Result<(), Error> {
            #[inline(never)]
            fn plane(engine: &mut $plane, elements: &Elements<'_, f64, 2>, sink: $sink) -> Result<(), Error> {
                engine.$method(elements, sink)
            }

            #[inline(never)]
            fn space(engine: &mut $space, elements: &Elements<'_, f64, 3>, sink: $sink) -> Result<(), Error> {
                engine.$method(elements, sink)
            }

            if const { D == 2 && T::IS_F64 } {
                plane($crate::compiled::same(engine), &elements.in_f64(), sink)
            } else if const { D == 3 && T::IS_F64 } {
                space($crate::compiled::same(engine), &elements.in_f64(), sink)
            } else {
                engine.$method(elements, sink)
            }
        }
    };
}

pub(crate) use compiled;

/// The same value, whose type the caller knows to be `B`.
pub(crate) fn same<A: 'static, B: 'static>(value: &mut A) -> &mut B {
    (value as &mut dyn Any).downcast_mut().expect("the types were compared before")
}
