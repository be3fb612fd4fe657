//! Functions that are compiled with this crate, for triangles and for tetrahedra.
//!
//! A generic function is compiled in each crate that calls it, with the options of that crate: slowly, and
//! not optimised in crates that are built quickly. There are only two kinds of elements, so functions that
//! take long for a large model are compiled here.

use std::any::Any;

/// Calls a function of the crate that is compiled here for both kinds of elements: `(arguments and their
/// types) -> result = function`. Each type is given for triangles and for tetrahedra. `D` and `N` are
/// those of the caller.
macro_rules! compiled {
    (($($name:ident: $pass:ident [$plane:ty, $space:ty]),*) -> [$of_plane:ty, $of_space:ty] = $function:path) => {{
        #[inline(never)]
        fn plane($($name: $crate::compiled::passed!($pass $plane)),*) -> $of_plane {
            $function($($name),*)
        }

        #[inline(never)]
        fn space($($name: $crate::compiled::passed!($pass $space)),*) -> $of_space {
            $function($($name),*)
        }

        if const { <[[f64; D]; N] as $crate::simplex::Simplex<D, N>>::IS_TRIANGLE } {
            $crate::compiled::value(plane($($crate::compiled::$pass($name)),*))
        } else {
            $crate::compiled::value(space($($crate::compiled::$pass($name)),*))
        }
    }};
}

/// The type of an argument that is passed by value, by reference or by mutable reference.
macro_rules! passed {
    (as_is $type:ty) => {
        $type
    };
    (value $type:ty) => {
        $type
    };
    (reference $type:ty) => {
        &$type
    };
    (change $type:ty) => {
        &mut $type
    };
}

pub(crate) use {compiled, passed};

/// A value that does not depend on the dimension.
pub(crate) fn as_is<A>(value: A) -> A {
    value
}

/// The same value, whose type the caller knows to be `B`.
pub(crate) fn value<A: 'static, B: 'static>(value: A) -> B {
    let mut slot = Some(value);
    let same = (&mut slot as &mut dyn Any).downcast_mut::<Option<B>>().expect("the dimension is that of `B`");
    same.take().expect("the value was put there")
}

/// A reference to the same value, whose type the caller knows to be `B`.
pub(crate) fn reference<A: 'static, B: 'static>(value: &A) -> &B {
    (value as &dyn Any).downcast_ref().expect("the dimension is that of `B`")
}

/// A mutable reference to the same value, whose type the caller knows to be `B`.
pub(crate) fn change<A: 'static, B: 'static>(value: &mut A) -> &mut B {
    (value as &mut dyn Any).downcast_mut().expect("the dimension is that of `B`")
}
