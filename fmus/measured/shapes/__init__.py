"""Mode shapes at nodes: files of programs and modal tests in, what they are at the contact point out."""
